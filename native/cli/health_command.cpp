#include <fmt/format.h>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/terminal.h"
#include "server/net/http_get.h"

namespace isosplat::cli {
namespace {

struct HealthCall {
  uint16_t port = 8080;
};

int run(const HealthCall& call) {
  // Tries without TLS first, and then with it, since a port supports only one of them. The
  // certificate is not verified, since it is for the server's public name.
  const server::HttpGetOptions options{
      .timeout = std::chrono::seconds(2), .max_bytes = 64 * 1024, .verifies_certificate = false};
  const auto ask = [&](const char* scheme) {
    return server::http_get(fmt::format("{}://localhost:{}/readyz", scheme, call.port), options);
  };
  Result<server::HttpAnswer> answer = ask("http");
  if (!answer) {
    const Result<server::HttpAnswer> with_tls = ask("https");
    if (with_tls) answer = with_tls;
  }
  if (!answer) return report(answer.error());
  if (answer->status == 200) return kSuccess;
  return report(
      {Status::io_error, fmt::format("port {}: expected status 200 from /readyz, found {}: {}",
                                     call.port, answer->status, answer->body)});
}

}  // namespace

void add_health_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "health", "Check whether a server on this machine is ready, with or without TLS");
  auto call = std::make_shared<HealthCall>();
  command->add_option("--port", call->port, "Port of the server")
      ->check(is_whole_number(1, 65535))
      ->capture_default_str();
  command->footer(
      examples("  isosplat health --port 8443\n"
               "The exit code is 0 if /readyz responds with status 200, otherwise 1. Containers "
               "can use this\n"
               "command as their health check."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
