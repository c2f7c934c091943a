#include "server/capacity.h"

#include <fmt/format.h>

#include <sys/resource.h>

#include <algorithm>

namespace isosplat::server {
namespace {

/// Raises the soft limit of open files to the hard limit, since each store and each connection uses
/// one. Returns the limit.
uint64_t raise_open_file_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return UINT64_MAX;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
  ::getrlimit(RLIMIT_NOFILE, &limit);
  return limit.rlim_cur;
}

/// The number of descriptors that stores and connections may use. The process needs the others for
/// threads that read headers, for logs, for listening sockets, and for refused connections.
uint64_t spare_descriptors() {
  constexpr uint64_t kOthers = 2 * uint64_t{Admission::kMostRefusals};
  const uint64_t all = raise_open_file_limit();
  return all - std::min(all / 2, kOthers);
}

}  // namespace

StorePool::Limits pool_limits(const ServerLimits& limits) {
  const uint64_t most = std::max<uint64_t>(raise_open_file_limit() / 4, 1);
  return {static_cast<size_t>(std::min<uint64_t>(limits.open_stores, most)), limits.directory_bytes,
          limits.all_directory_bytes};
}

Admission::Limits admission_limits(const ServerLimits& limits) {
  const uint64_t most = spare_descriptors() - pool_limits(limits).stores;
  return {.connections = static_cast<uint32_t>(std::min<uint64_t>(limits.connections, most)),
          .per_address = limits.connections_per_address,
          .least_rate = limits.least_rate,
          .patience = limits.patience};
}

std::string descriptor_warning(const ServerLimits& limits) {
  const uint64_t stores = limits.open_stores, connections = limits.connections;
  const uint64_t spare = spare_descriptors();
  if (stores + connections <= spare) return {};
  return fmt::format(
      "the system allows {} open files, fewer than {} connections and {} open stores need ({}): "
      "the limits are now {} and {}. Raise it (ulimit -n, LimitNOFILE= of systemd), or lower them",
      raise_open_file_limit(), connections, stores,
      stores + connections + raise_open_file_limit() - spare, admission_limits(limits).connections,
      pool_limits(limits).stores);
}

RouterLimits router_limits(const ServerLimits& limits) {
  return {.query_bytes = limits.query_bytes,
          .query_chunks = limits.query_chunks,
          .query_directory_bytes = limits.query_directory_bytes,
          .target_bytes = limits.target_bytes};
}

uint64_t bytes_of_one(const ServerLimits& limits) {
  return limits.connections_per_address == 0 ? UINT64_MAX : limits.bytes_in_flight / 4;
}

}  // namespace isosplat::server
