#include "native/scene/scene_output.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <fstream>

#include "native/files/output_file.h"
#include "native/scene/bundle.h"
#include "native/scene/scene_text.h"

namespace isosplat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBundleExtension = ".isobundle";
/// The file that lists the complete stores. It has a line for each, with its name, a blank, and the
/// hash of its key. If a name occurs twice, the last line is valid.
constexpr const char* kKeys = ".isosplat-build";
constexpr size_t kHashDigits = 32;

std::string hash(const std::string& key) {
  const XXH128_hash_t found = XXH3_128bits(key.data(), key.size());
  return fmt::format("{:016x}{:016x}", found.high64, found.low64);
}

/// A line that an interrupted build has not completed is left out.
std::map<std::string, std::string> read_keys(const fs::path& file) {
  std::ifstream in(file);
  std::map<std::string, std::string> keys;
  for (std::string name, key; in >> name >> key;) {
    if (key.size() == kHashDigits) keys[name] = key;
  }
  return keys;
}

std::string line_of(const std::string& name, const std::string& key) {
  return fmt::format("{} {}\n", name, key);
}

Result<void> write_text(const fs::path& path, const std::string& text) {
  return write_whole_file(path, std::as_bytes(std::span(text)));
}

}  // namespace

bool SceneOutput::is_scene(const fs::path& path) {
  return path.extension() == kBundleExtension || !path.has_filename();
}

Result<void> SceneOutput::check(const Scene& scene) {
  if (const size_t count = store_paths(scene).size(); count > kMaxBundleStores) {
    return fail(Status::invalid_argument,
                fmt::format("expected a scene of at most {} stores, found {}: build fewer steps",
                            kMaxBundleStores, count));
  }
  if (const auto read = parse_scene(scene_text(scene)); !read) return tl::unexpected(read.error());
  return {};
}

Result<SceneOutput> SceneOutput::create(const fs::path& path, bool force) {
  SceneOutput output;
  output.path_ = path;
  output.is_bundle_ = path.extension() == kBundleExtension;
  output.folder_ = output.is_bundle_
                       ? path.parent_path() / fmt::format(".{}.parts", path.filename().string())
                       : path;
  std::error_code failed;
  const bool is_own = fs::exists(output.folder_ / kKeys, failed);
  if (!output.is_bundle_ && !force && !is_own && fs::exists(path / kSceneName, failed)) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected no scene, or one of isosplat build, found another: "
                            "choose another folder with -o, or replace the scene with --force",
                            (path / kSceneName).string()));
  }
  fs::create_directories(output.folder_ / "stores", failed);
  if (failed) {
    return fail(Status::io_error, fmt::format("{}: cannot create the folder: {}",
                                              output.folder_.string(), failed.message()));
  }
  output.keys_ = read_keys(output.folder_ / kKeys);
  if (is_own) {  // without outdated and incomplete lines
    std::string lines;
    for (const auto& [name, key] : output.keys_) lines += line_of(name, key);
    auto written = write_text(output.folder_ / kKeys, lines);
    if (!written) return tl::unexpected(written.error());
  }
  return output;
}

std::string SceneOutput::store_path(const std::string& name) {
  return "stores/" + name + ".isosplat";
}

fs::path SceneOutput::store_file(const std::string& name) const {
  return folder_ / store_path(name);
}

bool SceneOutput::has(const std::string& name, const std::string& key) const {
  const auto found = keys_.find(name);
  return found != keys_.end() && found->second == hash(key) && StoreFile::open(store_file(name));
}

Result<void> SceneOutput::completed(const std::string& name, const std::string& key) {
  std::string& hashed = keys_[name];
  hashed = hash(key);
  // Appended, since a scene may have thousands of stores.
  std::ofstream keys(folder_ / kKeys, std::ios::app);
  keys << line_of(name, hashed) << std::flush;
  if (keys) return {};
  return fail(Status::io_error, fmt::format("{}: cannot be written: check the free space",
                                            (folder_ / kKeys).string()));
}

Result<uint64_t> SceneOutput::finish(const Scene& scene) {
  const fs::path document = folder_ / kSceneName;
  const std::string text = scene_text(scene);
  if (auto valid = check(scene); !valid) return tl::unexpected(valid.error());
  if (auto written = write_text(document, text); !written) return tl::unexpected(written.error());
  if (!is_bundle_) {
    uint64_t bytes = text.size();
    for (const std::string& store : store_paths(scene)) {
      std::error_code failed;
      bytes += fs::file_size(folder_ / store, failed);
      if (failed) {
        return fail(Status::io_error, fmt::format("{}: cannot be read: {}",
                                                  (folder_ / store).string(), failed.message()));
      }
    }
    return bytes;
  }
  const auto file = SceneFile::open(document);
  if (!file) return tl::unexpected(file.error());
  const auto bytes = write_bundle(*file, path_);
  if (!bytes) return tl::unexpected(bytes.error());
  std::error_code ignored;  // what is left is used by the next build
  fs::remove_all(folder_, ignored);
  return *bytes;
}

}  // namespace isosplat
