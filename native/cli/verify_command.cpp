#include "native/builder/verify.h"

#include <fmt/format.h>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/remote_flags.h"
#include "native/cli/terminal.h"
#include "native/remote/remote_target.h"
#include "shared/system/scene_file/scene_file.h"

namespace isosplat::cli {
namespace {

struct VerifyCall {
  std::vector<std::string> stores;
  unsigned threads = 0;
  RemoteFlags remote_flags;
};

/// Verifies one store, of a file or of a scene, and prints the result. `name`: for messages.
template <class Verify>
int verify_one(const VerifyCall& call, const std::string& name, Verify verify) {
  ProgressLine line(fmt::format("Verifying {}", std::filesystem::path(name).filename().string()));
  VerifyOptions options;
  options.threads = call.threads;
  options.progress = [&](double fraction) { line.show(fraction, "decoding all chunks"); };
  const Result<VerifyReport> verified = verify(options);
  line.clear();
  if (!verified) {
    Error error = verified.error();
    if (!error.message.starts_with(name)) error.message = name + ": " + error.message;
    return report(error);
  }
  const std::string fields =
      verified->info.fields.empty()
          ? ""
          : fmt::format("{} chunks of {} field{}, ", with_commas(verified->field_chunks),
                        verified->info.fields.size(), verified->info.fields.size() == 1 ? "" : "s");
  fmt::print("{}: valid: {} chunks with {} cells, {}{}\n", printable(name),
             with_commas(verified->chunks), with_commas(verified->cells), fields,
             format_bytes(verified->info.file_bytes));
  return kSuccess;
}

/// A scene or a bundle, and each of its stores.
int verify_scene(const VerifyCall& call, const std::string& given) {
  const auto scene = open_scene(given, call.remote_flags);
  if (!scene) return report(scene.error());
  const std::string path = scene->path().string();
  int exit_code = kSuccess;
  for (const std::string& store : store_paths(scene->scene())) {
    const int code = verify_one(call, path + ": " + store, [&](VerifyOptions options) {
      options.threads = threads_for(given, options.threads);
      const auto bytes = scene->store_bytes(store);
      return bytes ? verify_store(*bytes, options)
                   : Result<VerifyReport>(tl::unexpected(bytes.error()));
    });
    if (code != kSuccess) exit_code = code;
  }
  if (exit_code == kSuccess) {
    fmt::print("{}: valid: {} layers\n", path, with_commas(scene->scene().layers.size()));
  }
  return exit_code;
}

int verify_remote(const VerifyCall& call, const std::string& address) {
  const auto object = call.remote_flags.object(address);
  if (!object) return report(object.error());
  const FileParts bytes(*object, (*object)->bytes());
  return verify_one(call, (*object)->name(), [&](VerifyOptions options) {
    options.threads = threads_for(address, options.threads);
    return verify_store(bytes, options).map_error([&](const Error& error) {
      return remote::store_error(error, (*object)->name());
    });
  });
}

int verify(const VerifyCall& call, const std::string& path) {
  if (scene_kind(path, call.remote_flags) != SceneKind::none) return verify_scene(call, path);
  if (remote::is_address(path)) return verify_remote(call, path);
  return verify_one(call, path,
                    [&](const VerifyOptions& options) { return verify_store_file(path, options); });
}

int run(const VerifyCall& call) {
  int exit_code = kSuccess;
  for (const std::string& path : call.stores) {
    const int code = verify(call, path);
    if (code != kSuccess) exit_code = code;
  }
  return exit_code;
}

}  // namespace

void add_verify_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "verify", "Check all checksums and chunks of stores, scenes and bundles");
  auto call = std::make_shared<VerifyCall>();
  command->add_option("stores", call->stores, "Stores, scenes or bundles, or their addresses")
      ->required();
  command->add_option("--threads", call->threads, "Number of threads (0: one per core)")
      ->check(is_whole_number(0, kMaxThreads))
      ->capture_default_str();
  call->remote_flags.add_to(*command);
  command->footer(
      examples("  isosplat verify engine.isosplat\n"
               "  isosplat verify stores/*.isosplat\n"
               "  isosplat verify s3://bucket/stores/engine.isosplat\n"));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
