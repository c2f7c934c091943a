#include <fmt/format.h>
#include <isosplat/version.h>
#include <sys/stat.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "native/cli/building.h"
#include "native/cli/command.h"
#include "native/cli/options.h"
#include "native/cli/server_flags.h"
#include "native/cli/serving.h"
#include "native/cli/terminal.h"
#include "server/access/access_rules.h"
#include "server/catalog/volume_names.h"
#include "shared/core/scene/bundle_header.h"
#include "shared/system/scene_file/bundle_bytes.h"
#include "shared/system/scene_file/scene_file.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::cli {
namespace {

struct ViewCall {
  std::string volume;
  ServerFlags server_flags;
  bool rebuild = false;
  VolumeFlags volume_flags;
  BuildFlags build_flags;
};

/// A file's path, size, mtime and ctime, as text. The ctime detects a file that was replaced by a
/// copy with the same mtime.
std::string identity(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return path.string() + "\n";
  return fmt::format("{}\n{}\n{}.{:09}\n{}.{:09}\n", path.string(), status.st_size,
                     status.st_mtim.tv_sec, status.st_mtim.tv_nsec, status.st_ctim.tv_sec,
                     status.st_ctim.tv_nsec);
}

/// The identities of all files of a volume: the header and data files that its source reads, and,
/// for a folder, all files below it, since a new file may belong to the series.
std::string volume_identity(const std::filesystem::path& volume, const VolumeSource& source) {
  std::error_code error;
  std::filesystem::path whole = std::filesystem::canonical(volume, error);
  if (error) whole = volume;
  std::vector<std::filesystem::path> files = source.files();
  if (std::filesystem::is_directory(whole, error)) {
    for (std::filesystem::recursive_directory_iterator entry(whole, error), end;
         !error && entry != end; entry.increment(error)) {
      files.push_back(entry->path());
    }
  }
  std::sort(files.begin(), files.end());
  std::string text = whole.string() + "\n";
  for (const auto& file : files) text += identity(file);
  return text;
}

Result<std::filesystem::path> cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  std::filesystem::path folder;
  if (cache && *cache == '/') {
    folder = std::filesystem::path(cache) / "isosplat";
  } else if (home && *home) {
    folder = std::filesystem::path(home) / ".cache" / "isosplat";
  } else {
    return fail(Status::io_error,
                "expected XDG_CACHE_HOME or HOME, found neither: set one of them for the cache of "
                "stores, or use isosplat build and serve");
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return fail(
        Status::io_error,
        fmt::format("{}: cannot create the cache folder: {}: set XDG_CACHE_HOME to another folder",
                    folder.string(), error.message()));
  }
  return folder;
}

/// The path of the store. It is the argument if that is a store, else the cached store of the
/// volume, which is built if it does not exist yet.
Result<std::filesystem::path> find_or_build_store(const ViewCall& call) {
  if (is_store(call.volume)) {
    const auto opened = StoreFile::open(call.volume);
    if (!opened) return tl::unexpected(opened.error());
    return std::filesystem::path(call.volume);
  }
  auto import_options = call.volume_flags.options();
  if (!import_options) return tl::unexpected(import_options.error());
  const auto build_options = call.build_flags.options();
  if (!build_options) return tl::unexpected(build_options.error());
  std::error_code error;
  if (!std::filesystem::exists(call.volume, error)) {
    return fail(Status::io_error,
                fmt::format("{}: expected a volume, found nothing: check the path", call.volume));
  }
  import_options->memory_bytes = build_options->memory_bytes;
  const auto opened = import::open_volume(call.volume, *import_options);
  if (!opened) return tl::unexpected(opened.error());
  const auto folder = cache_folder();
  if (!folder) return tl::unexpected(folder.error());
  const std::string key = volume_identity(call.volume, *opened->source) + call.volume_flags.key() +
                          "\n" + call.build_flags.key() + "\n" ISOSPLAT_VERSION;
  const XXH128_hash_t hash = XXH3_128bits(key.data(), key.size());
  const auto store =
      *folder / fmt::format("{}-{:016x}.isosplat", server::name_segment(store_stem(call.volume)),
                            hash.low64 ^ hash.high64);
  if (!call.rebuild && StoreFile::open(store)) {
    note(fmt::format("{} exists already: --rebuild builds it again", store.string()));
    return store;
  }
  auto built = build_with_progress(*opened, store, *build_options);
  if (!built) return tl::unexpected(built.error());
  return store;
}

/// The file of a scene: the argument, or scene.json in a folder. None: the argument is a volume.
std::optional<std::filesystem::path> scene_in(const std::string& argument) {
  const std::filesystem::path path(argument);
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) {
    return scene_kind(path) == SceneKind::none ? std::nullopt : std::optional(path);
  }
  if (!std::filesystem::is_regular_file(path / kSceneName, error)) return std::nullopt;
  return path / kSceneName;
}

/// Errors: those of a scene that cannot be served.
Result<void> check_scene(const std::filesystem::path& path) {
  if (!server::is_scene_file(path.filename().native())) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected a scene named NAME.isobundle, NAME.scene.json or "
                            "scene.json, found another name: rename it",
                            path.string()));
  }
  const auto scene = SceneFile::open(path);
  if (!scene) return tl::unexpected(scene.error());
  const auto bundle = BundleBytes::plan(*scene);
  if (!bundle) return tl::unexpected(bundle.error());
  return {};
}

int run(const ViewCall& call) {
  Result<server::ServerOptions> options = call.server_flags.options();
  if (!options) return report(options.error());
  const auto scene = scene_in(call.volume);
  if (scene) {
    if (auto checked = check_scene(*scene); !checked) return report(checked.error());
    options->stores = {*scene};
  } else {
    const auto store = find_or_build_store(call);
    if (!store) return report(store.error());
    options->stores = {*store};
  }
  // Other users of this machine can reach the port too, so reading requires the printed address.
  if (options->tokens.empty()) {
    auto token = server::random_token();
    if (!token) return report(token.error());
    options->tokens = {std::move(*token)};
  }
  const auto kind = scene ? server::ServedKind::scene : server::ServedKind::volume;
  const std::string query =
      fmt::format("token={}&{}={}", options->tokens.front(), server::word_of(kind),
                  server::file_segment(options->stores.front()));
  return serve_until_stopped(std::move(*options), query);
}

}  // namespace

void add_view_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "view", "Show a volume or a scene: build its store if needed, and serve it");
  auto call = std::make_shared<ViewCall>();
  command
      ->add_option("volume", call->volume,
                   "A store, a scene, or a volume in a format that isosplat build reads")
      ->required();
  call->server_flags.add_to(*command);
  command->add_flag("--rebuild", call->rebuild, "Build the store again even if it exists");
  call->build_flags.add_to(*command);
  call->volume_flags.add_to(*command);
  command->footer(examples(
      "  isosplat view head.nii.gz\n"
      "  isosplat view scans/ct --port 0\n"
      "  isosplat view engine.isosplat\n"
      "  isosplat view head.isobundle\n"
      "  isosplat view run/scene.json\n"
      "The printed address contains a token, without which nobody can read the volume.\n"
      "ISOSPLAT_TOKEN sets the token.\n"
      "Stores are kept in $XDG_CACHE_HOME/isosplat (default: ~/.cache/isosplat). A store is\n"
      "built again when the volume has changed."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
