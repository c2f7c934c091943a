#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "native/files/output_file.h"
#include "native/scene/scene_file.h"

namespace isosplat {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kCopyBytes = uint64_t{1} << 20;

/// Copies a range of a store to a place in the output.
Result<void> copy(const FileParts& from, uint64_t offset, uint64_t bytes, OutputFile& to,
                  uint64_t to_offset) {
  std::vector<std::byte> buffer(std::min(bytes, kCopyBytes));
  for (uint64_t done = 0; done < bytes; done += buffer.size()) {
    const auto part = std::span(buffer).first(std::min<uint64_t>(buffer.size(), bytes - done));
    if (auto read = from.read(offset + done, part); !read) return read;
    if (auto written = to.write(to_offset + done, part); !written) return written;
  }
  return {};
}

Result<void> write_file(const fs::path& path, std::span<const std::byte> bytes) {
  auto output = OutputFile::create(path);
  if (!output) return tl::unexpected(output.error());
  if (auto written = output->write(0, bytes); !written) return written;
  return output->publish();
}

}  // namespace

Result<uint64_t> write_bundle(const SceneFile& scene, const fs::path& output) {
  std::vector<BundleStore> stores;
  std::vector<FileParts> sources;
  for (const std::string& path : store_paths(scene.scene())) {
    if (!is_path_below(path) || path == kSceneName) {
      return fail(Status::malformed_header,
                  fmt::format("store {}: expected a store in the folder of the scene or below: "
                              "copy the store there, and name it by its relative path",
                              path));
    }
    auto bytes = scene.store_bytes(path);
    if (!bytes) return tl::unexpected(bytes.error());
    const auto opened = scene.open_store(path);  // checks the header and the size
    if (!opened) return tl::unexpected(opened.error());
    const StoreFile& store = **opened;
    BundleStore entry;
    entry.path = path;
    entry.file_bytes = store.info().file_bytes;
    entry.header_bytes = store.info().header_bytes;
    entry.bootstrap_offset = store.bootstrap().offset;
    entry.bootstrap_bytes = store.bootstrap().bytes;
    entry.content_id = store.info().content_id;
    stores.push_back(std::move(entry));
    sources.push_back(std::move(*bytes));
  }
  const auto header = plan_bundle(scene.text(), std::move(stores));
  if (!header) return tl::unexpected(header.error());
  auto file = OutputFile::create(output);
  if (!file) return tl::unexpected(file.error());
  if (auto written = file->write(0, encode_bundle_header(*header)); !written) {
    return tl::unexpected(written.error());
  }
  // In the order of the bundle: the coarse parts of all stores, then the fine parts.
  struct Copy {
    size_t store;
    BundlePiece piece;
  };
  std::vector<Copy> copies;
  for (size_t i = 0; i < header->stores.size(); ++i) {
    for (const BundlePiece& piece : header->stores[i].pieces()) copies.push_back({i, piece});
  }
  std::sort(copies.begin(), copies.end(), [](const Copy& a, const Copy& b) {
    return a.piece.bundle_offset < b.piece.bundle_offset;
  });
  for (const auto& [store, piece] : copies) {
    const auto copied =
        copy(sources[store], piece.store_offset, piece.bytes, *file, piece.bundle_offset);
    if (!copied) return tl::unexpected(copied.error());
  }
  if (auto published = file->publish(); !published) return tl::unexpected(published.error());
  return header->file_bytes;
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
    if (auto copied = copy(*bytes, 0, bytes->bytes(), *file, 0); !copied) {
      return tl::unexpected(copied.error());
    }
    if (auto published = file->publish(); !published) return tl::unexpected(published.error());
  }
  // Last: a folder with a scene has all its stores.
  if (auto written = write_file(folder / kSceneName, std::as_bytes(std::span(bundle.text())));
      !written) {
    return tl::unexpected(written.error());
  }
  return names.size();
}

}  // namespace isosplat
