#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "server/server.h"

namespace isosplat::cli {

/// The options of serve for the operation of the server: threads, limits and logs.
class OperationFlags {
 public:
  void add_to(CLI::App& command);

  /// Sets the options that were given. Errors: invalid_argument.
  Result<void> apply(server::ServerOptions& options) const;

 private:
  std::string access_log_, log_format_ = "common", rate_bytes_ = "0", bytes_in_flight_ = "256M";
  double rate_requests_ = 0;
  uint32_t threads_ = 0, disk_threads_ = server::ServerOptions{}.disk_threads,
           connections_ = server::ServerLimits{}.connections,
           connections_per_address_ = server::ServerLimits{}.connections_per_address,
           open_stores_ = server::ServerLimits{}.open_stores;
  bool verbose_ = false, no_outside_links_ = false;
};

}  // namespace isosplat::cli
