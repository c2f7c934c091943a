#include "native/cli/server_flags.h"

#include <fmt/format.h>

#include <cstdlib>
#include <utility>

#include "native/cli/durations.h"
#include "native/cli/numbers.h"
#include "native/cli/serving.h"

namespace isosplat::cli {

void ServerFlags::add_to(CLI::App& command) {
  command.add_option("--port", port_, "Port (0: any free port)")
      ->check(is_whole_number(0, 65535))
      ->capture_default_str();
  command
      .add_option("--host", host_,
                  "Address to listen on (0.0.0.0: all networks; needs --cors or --public)")
      ->capture_default_str();
  CLI::Option* cors =
      command.add_option("--cors", cross_origin_,
                         "Other web sites whose pages may read the volumes: none, '*', or origins "
                         "such as https://a.example,https://b.example");
  command.add_option("--allow-host", allowed_hosts_,
                     "Host name under which clients may address this server, for example behind a "
                     "proxy ('*': any)");
  command
      .add_flag("--public", is_public_,
                "Let any web page read the volumes, under any host name of this server")
      ->excludes(cors);
  CLI::Option* certificate =
      command.add_option("--tls-cert", tls_certificate_,
                         "File with the certificate and its chain (PEM), for https://");
  CLI::Option* key = command.add_option("--tls-key", tls_key_,
                                        "File with the private key of the certificate (PEM)");
  certificate->needs(key);
  key->needs(certificate);
  command
      .add_option("--http-port", http_port_,
                  "With TLS: also listen on this port, and redirect its requests to https")
      ->needs(certificate)
      ->check(is_whole_number(0, 65535));
  command
      .add_option("--https-port", https_port_,
                  "Port to which these requests are redirected (default: that of --port)")
      ->check(is_whole_number(1, 65535));
  command
      .add_option(
          "--hsts", hsts_,
          "Tell browsers to use only https for this host during this time, such as 1h or 365d")
      ->type_name("TIME");
  command.add_option("--token-file", token_file_,
                     "File that states who may read which volumes: each line has a token (or "
                     "anyone), then names or paths of volumes");
  command.add_option("--link-key-file", link_key_file_,
                     "File with the key that verifies the links of sign-link (at least 32 bytes)");
  command.add_option("--revoked-links", revoked_links_,
                     "File that revokes links: each line has the first 16 digits of a link's sig");
  command.add_option("--web-root", web_root_,
                     "Folder with the page (default: the page built with this program)");
}

Result<server::ServerOptions> ServerFlags::options() const {
  server::ServerOptions options;
  options.log_file = server::LogFile::standard_error();
  options.host = host_;
  options.port = port_;
  options.web_root = find_page(web_root_);
  options.is_public = is_public_;
  options.tls_certificate = tls_certificate_;
  options.tls_key = tls_key_;
  options.http_port = http_port_;
  options.https_port = https_port_;
  if (!hsts_.empty()) {
    const auto seconds = parse_duration(hsts_);
    if (!seconds) {
      return fail(Status::invalid_argument,
                  fmt::format("--hsts: expected a time such as 1h or 365d, found '{}'", hsts_));
    }
    options.hsts_seconds = static_cast<uint64_t>(*seconds);
  }
  options.token_file = token_file_;
  options.link_key_file = link_key_file_;
  options.revoked_links_file = revoked_links_;
  // Other users can see the arguments of a program, but not its environment.
  if (const char* token = std::getenv("ISOSPLAT_TOKEN"); token && *token) {
    options.tokens.emplace_back(token);
  }
  if (const char* key = std::getenv("ISOSPLAT_LINK_KEY"); key && *key) options.link_key = key;
  if (!cross_origin_.empty()) {
    Result<server::CrossOrigin> parsed = server::parse_cross_origin(cross_origin_);
    if (!parsed) return fail(Status::invalid_argument, "--cors: " + parsed.error().message);
    options.cross_origin = std::move(*parsed);
  }
  for (const std::string& name : allowed_hosts_) {
    if (name != "*" && server::host_of(name).empty()) {
      return fail(
          Status::invalid_argument,
          fmt::format("--allow-host: expected a host name such as volumes.example, found '{}'",
                      name));
    }
    options.allowed_hosts.push_back(name);
  }
  return options;
}

}  // namespace isosplat::cli
