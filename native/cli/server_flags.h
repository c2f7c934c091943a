#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/server.h"

namespace isosplat::cli {

/// The options of serve and view for the address of the server and for access to it.
class ServerFlags {
 public:
  void add_to(CLI::App& command);

  /// Reads ISOSPLAT_TOKEN and ISOSPLAT_LINK_KEY as well. Errors: invalid_argument.
  Result<server::ServerOptions> options() const;

 private:
  std::string host_ = "127.0.0.1", web_root_, cross_origin_, token_file_, link_key_file_,
              tls_certificate_, tls_key_, revoked_links_, hsts_;
  std::vector<std::string> allowed_hosts_;
  uint16_t port_ = 8080, https_port_ = 0;
  std::optional<uint16_t> http_port_;
  bool is_public_ = false;
};

}  // namespace isosplat::cli
