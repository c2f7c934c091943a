#include "native/cli/server_flags.h"

#include <fmt/format.h>

#include <cstdlib>
#include <utility>

#include "native/cli/numbers.h"
#include "native/cli/serving.h"

namespace isosplat::cli {

void ServerFlags::add_to(CLI::App& command) {
  command.add_option("--port", port_, "Port (0: any free port)")
      ->check(is_whole_number(0, 65535))
      ->capture_default_str();
  command.add_option("--host", host_, "Address (0.0.0.0: every network; needs --cors or --public)")
      ->capture_default_str();
  CLI::Option* cors =
      command.add_option("--cors", cross_origin_,
                         "Web pages of other sites that may read the volumes: none, '*', or "
                         "origins such as https://a.example,https://b.example");
  command.add_option("--allow-host", allowed_hosts_,
                     "A name of this server in addresses, behind a proxy for example; '*': any");
  command
      .add_flag("--public", is_public_,
                "Any web page may read the volumes, by any name of this server")
      ->excludes(cors);
  CLI::Option* certificate = command.add_option("--tls-cert", tls_certificate_,
                                                "Certificate with its chain (PEM), for https://");
  CLI::Option* key = command.add_option("--tls-key", tls_key_, "Its private key (PEM)");
  certificate->needs(key);
  key->needs(certificate);
  command.add_option("--token-file", token_file_,
                     "Who may read: lines of a token (or anyone) and names or folders of volumes");
  command.add_option("--link-key-file", link_key_file_,
                     "Key of the links that sign-link makes (at least 32 bytes)");
  command.add_option("--web-root", web_root_,
                     "Folder with the page (default: the page built with this program)");
}

Result<ServerOptions> ServerFlags::options() const {
  ServerOptions options;
  options.host = host_;
  options.port = port_;
  options.web_root = find_page(web_root_);
  options.is_public = is_public_;
  options.tls_certificate = tls_certificate_;
  options.tls_key = tls_key_;
  options.token_file = token_file_;
  options.link_key_file = link_key_file_;
  // Other users see the arguments of a program, but not its environment.
  if (const char* token = std::getenv("ISOSPLAT_TOKEN"); token && *token) {
    options.tokens.emplace_back(token);
  }
  if (const char* key = std::getenv("ISOSPLAT_LINK_KEY"); key && *key) options.link_key = key;
  if (!cross_origin_.empty()) {
    Result<CrossOrigin> parsed = parse_cross_origin(cross_origin_);
    if (!parsed) return fail(Status::invalid_argument, "--cors: " + parsed.error().message);
    options.cross_origin = std::move(*parsed);
  }
  for (const std::string& name : allowed_hosts_) {
    if (name != "*" && host_of(name).empty()) {
      return fail(Status::invalid_argument,
                  fmt::format("--allow-host: expected a host name, found '{}'", name));
    }
    options.allowed_hosts.push_back(name);
  }
  return options;
}

}  // namespace isosplat::cli
