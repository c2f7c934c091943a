#include "native/cli/operation_flags.h"

#include <fmt/format.h>

#include <map>

#include "native/cli/numbers.h"

namespace isosplat::cli {
namespace {

const std::map<std::string, server::LogFormat>& log_formats() {
  static const std::map<std::string, server::LogFormat> formats = {
      {"plain", server::LogFormat::plain},
      {"common", server::LogFormat::common},
      {"json", server::LogFormat::json}};
  return formats;
}

Result<uint64_t> parse_size(const char* option, const std::string& text) {
  const auto bytes = parse_bytes(text);
  if (bytes) return *bytes;
  return fail(Status::invalid_argument,
              fmt::format("{}: expected a size such as 512K or 20M, found '{}'", option, text));
}

}  // namespace

void OperationFlags::add_to(CLI::App& command) {
  command.add_option("--threads", threads_, "Number of threads (0: one per core)")
      ->check(is_whole_number(0, server::kMaxServerThreads))
      ->capture_default_str();
  command
      .add_option("--disk-threads", disk_threads_,
                  "Limit of slow disk reads at the same time, each on a thread of its own")
      ->check(is_whole_number(1, server::kMaxServerThreads))
      ->capture_default_str();
  command.add_option("--connections", connections_, "Limit of open connections")
      ->check(is_whole_number(1, 1'000'000))
      ->capture_default_str();
  command
      .add_option("--connections-per-address", connections_per_address_,
                  "Limit of open connections from one address (0: no limit)")
      ->check(is_whole_number(0, 1'000'000))
      ->capture_default_str();
  command
      .add_option("--rate-requests", rate_requests_,
                  "Limit of requests per second for each token or address (0: no limit)")
      ->check(is_number(0, 1e9))
      ->capture_default_str();
  command
      .add_option("--rate-bytes", rate_bytes_,
                  "Limit of bytes sent per second for each token or address (0: no limit)")
      ->type_name("SIZE")
      ->capture_default_str();
  command
      .add_option("--bytes-in-flight", bytes_in_flight_,
                  "Limit of memory for response bodies that are being sent")
      ->type_name("SIZE")
      ->capture_default_str();
  command
      .add_option("--open-stores", open_stores_,
                  "Limit of open stores (the least recently used one is closed first)")
      ->check(is_whole_number(1, 1'000'000))
      ->capture_default_str();
  command
      .add_option("--access-log", access_log_,
                  "Append a line for each response to this file ('-': standard output)")
      ->type_name("FILE");
  command
      .add_option("--log-format", log_format_, "Format of the access log: plain, common or json")
      ->check(CLI::IsMember(log_formats()))
      ->capture_default_str();
  command.add_flag("--no-outside-links", no_outside_links_,
                   "Do not follow links in the served folders to stores outside of these folders");
  command.add_flag("-v,--verbose", verbose_, "Print each request");
}

Result<void> OperationFlags::apply(server::ServerOptions& options) const {
  const Result<uint64_t> rate_bytes = parse_size("--rate-bytes", rate_bytes_);
  if (!rate_bytes) return tl::unexpected(rate_bytes.error());
  const Result<uint64_t> in_flight = parse_size("--bytes-in-flight", bytes_in_flight_);
  if (!in_flight) return tl::unexpected(in_flight.error());
  options.threads = threads_;
  options.disk_threads = disk_threads_;
  options.limits.connections = connections_;
  options.limits.connections_per_address = connections_per_address_;
  options.limits.requests_per_second = rate_requests_;
  options.limits.bytes_per_second = static_cast<double>(*rate_bytes);
  options.limits.bytes_in_flight = *in_flight;
  options.limits.open_stores = open_stores_;
  options.follow_outside_links = !no_outside_links_;
  options.access_log_file = access_log_;
  if (!access_log_.empty()) options.log_format = log_formats().at(log_format_);
  if (verbose_) {
    options.access_log = [file = options.log_file](std::string_view line) { file->add(line); };
  }
  return {};
}

}  // namespace isosplat::cli
