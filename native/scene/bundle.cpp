#include "native/scene/bundle.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <vector>

#include "native/files/output_file.h"
#include "shared/system/scene_file/bundle_bytes.h"

namespace isosplat {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kCopyBytes = uint64_t{1} << 20;

/// Copies all bytes of a store or a bundle.
template <class Bytes>
Result<void> copy(const Bytes& from, OutputFile& to) {
  std::vector<std::byte> buffer(std::min(from.bytes(), kCopyBytes));
  for (uint64_t done = 0; done < from.bytes(); done += buffer.size()) {
    const auto part =
        std::span(buffer).first(std::min<uint64_t>(buffer.size(), from.bytes() - done));
    if (auto read = from.read(done, part); !read) return read;
    if (auto written = to.write(done, part); !written) return written;
  }
  return {};
}

}  // namespace

Result<uint64_t> write_bundle(const SceneFile& scene, const fs::path& output) {
  const auto bundle = BundleBytes::plan(scene);
  if (!bundle) return tl::unexpected(bundle.error());
  auto file = OutputFile::create(output);
  if (!file) return tl::unexpected(file.error());
  if (auto copied = copy(*bundle, *file); !copied) return tl::unexpected(copied.error());
  if (auto published = file->publish(); !published) return tl::unexpected(published.error());
  return bundle->bytes();
}

Result<size_t> unbundle(const SceneFile& bundle, const fs::path& folder, bool force) {
  std::vector<std::string> names{kSceneName};
  for (const BundleStore& store : bundle.bundle().stores) names.push_back(store.path);
  for (const std::string& name : names) {
    std::error_code ignored;
    if (!force && fs::exists(fs::symlink_status(folder / name, ignored))) {
      return fail(Status::invalid_argument,
                  fmt::format("{}: expected no file, found one: choose another folder with -o, or "
                              "replace the file with --force",
                              (folder / name).string()));
    }
  }
  for (const std::string& name : names) {
    std::error_code failed;
    fs::create_directories((folder / name).parent_path(), failed);
    if (failed) {
      return fail(Status::io_error,
                  fmt::format("{}: cannot create the folder: {}",
                              (folder / name).parent_path().string(), failed.message()));
    }
  }
  for (const BundleStore& store : bundle.bundle().stores) {
    const auto bytes = bundle.store_bytes(store.path);
    if (!bytes) return tl::unexpected(bytes.error());
    auto file = OutputFile::create(folder / store.path);
    if (!file) return tl::unexpected(file.error());
    if (auto copied = copy(*bytes, *file); !copied) {
      return tl::unexpected(copied.error());
    }
    if (auto published = file->publish(); !published) return tl::unexpected(published.error());
  }
  // Last: a folder with a scene has all its stores.
  if (auto written = write_whole_file(folder / kSceneName, std::as_bytes(std::span(bundle.text())));
      !written) {
    return tl::unexpected(written.error());
  }
  return names.size();
}

}  // namespace isosplat
