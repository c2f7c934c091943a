#include "native/builder/verify.h"

#include <fmt/format.h>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/terminal.h"

namespace isosplat::cli {
namespace {

struct VerifyCall {
  std::vector<std::string> stores;
  unsigned threads = 0;
};

int run(const VerifyCall& call) {
  int exit_code = kSuccess;
  for (const std::string& path : call.stores) {
    ProgressLine line(fmt::format("Verifying {}", std::filesystem::path(path).filename().string()));
    VerifyOptions options;
    options.threads = call.threads;
    options.progress = [&](double fraction) { line.show(fraction, "decoding all chunks"); };
    const auto verified = verify_store_file(path, options);
    line.clear();
    if (!verified) {
      Error error = verified.error();
      if (!error.message.starts_with(path)) error.message = path + ": " + error.message;
      exit_code = report(error);
      continue;
    }
    fmt::print("{}: valid: {} chunks with {} cells, {}\n", path, with_commas(verified->chunks),
               with_commas(verified->cells), format_bytes(verified->info.file_bytes));
  }
  return exit_code;
}

}  // namespace

void add_verify_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand("verify", "Check all checksums and chunks of stores");
  auto call = std::make_shared<VerifyCall>();
  command->add_option("stores", call->stores, "Store files")->required();
  command->add_option("--threads", call->threads, "Threads (0: one per core)")
      ->check(is_whole_number(0, kMaxThreads))
      ->capture_default_str();
  command->footer(
      examples("  isosplat verify engine.isosplat\n"
               "  isosplat verify stores/*.isosplat\n"));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
