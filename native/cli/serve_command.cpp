#include <fmt/format.h>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/serving.h"
#include "native/cli/terminal.h"

namespace isosplat::cli {
namespace {

struct ServeCall {
  std::vector<std::string> stores;
  std::string host = "127.0.0.1", web_root;
  uint16_t port = 8080;
  uint32_t threads = 0;
  bool verbose = false;
};

int run(const ServeCall& call) {
  ServerOptions options;
  options.host = call.host;
  options.port = call.port;
  options.threads = call.threads;
  options.stores.assign(call.stores.begin(), call.stores.end());
  options.web_root = find_page(call.web_root);
  for (const std::filesystem::path& store : options.stores) {
    std::error_code error;
    if (!std::filesystem::exists(store, error)) {
      return report({Status::io_error, fmt::format("{}: expected a store or a folder of stores, "
                                                   "found nothing: check the path, or build a "
                                                   "store with isosplat build",
                                                   store.string())});
    }
  }
  if (call.verbose) {
    options.access_log = [](std::string_view line) { fmt::print(stderr, "{}\n", line); };
  }
  return serve_until_stopped(std::move(options), "");
}

}  // namespace

void add_serve_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand("serve", "Serve stores and the page over HTTP");
  auto call = std::make_shared<ServeCall>();
  command->add_option("stores", call->stores, "Store files, and folders with *.isosplat files")
      ->required();
  command->add_option("--port", call->port, "Port (0: any free port)")
      ->check(is_whole_number(0, 65535))
      ->capture_default_str();
  command->add_option("--host", call->host, "Address (0.0.0.0: every network)")
      ->capture_default_str();
  command->add_option("--web-root", call->web_root,
                      "Folder with the page (default: the page built with this program)");
  command
      ->add_option("--threads", call->threads, "Threads (0: one per core; use more for slow disks)")
      ->check(is_whole_number(0, kMaxServerThreads))
      ->capture_default_str();
  command->add_flag("-v,--verbose", call->verbose, "Print each request");
  command->footer(
      examples("  isosplat serve engine.isosplat head.isosplat\n"
               "  isosplat serve stores/ --port 8081\n"
               "  isosplat serve stores/ --host 0.0.0.0\n"
               "New and replaced stores of a folder are served within a second."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
