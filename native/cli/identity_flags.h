#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "server/server.h"

namespace isosplat::cli {

/// The options of serve for tokens of an identity provider.
class IdentityFlags {
 public:
  void add_to(CLI::App& command);

  /// Sets the options that were given.
  void apply(server::ServerOptions& options) const;

 private:
  std::string jwt_keys_;
  server::JwtOptions jwt_;
};

}  // namespace isosplat::cli
