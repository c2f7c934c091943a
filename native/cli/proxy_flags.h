#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "server/server.h"

namespace isosplat::cli {

/// The options of serve for a server behind a proxy or a balancer.
class ProxyFlags {
 public:
  void add_to(CLI::App& command);

  /// Sets the options that were given. Errors: invalid_argument.
  Result<void> apply(server::ServerOptions& options) const;

 private:
  std::vector<std::string> trusted_proxies_;
  std::string proxy_header_ = "x-forwarded-for", user_header_, groups_header_, cookie_name_;
};

}  // namespace isosplat::cli
