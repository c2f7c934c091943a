#include "shared/system/scene_file/bundle_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

namespace isosplat {
namespace {

namespace fs = std::filesystem;

Error changed(const std::string& name) {
  return {Status::io_error,
          name +
              ": expected the file as it was when the scene was opened, found a changed one: "
              "open the scene again"};
}

/// The identity of a file, if it is in a folder once links are resolved. It is compared with the
/// file that is opened later, since a link can change in between.
std::optional<FileIdentity> identity_within(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  const fs::path real = fs::canonical(file, error);
  if (error) return std::nullopt;
  const fs::path real_folder = fs::canonical(folder, error);
  if (error) return std::nullopt;
  const bool is_within =
      std::mismatch(real_folder.begin(), real_folder.end(), real.begin(), real.end()).first ==
      real_folder.end();
  if (!is_within) return std::nullopt;
  const auto identity = file_identity(real);
  return identity ? std::optional(*identity) : std::nullopt;
}

/// The stores of the first picture: those of visible layers, at the step that is shown first.
std::set<std::string_view> first_stores(const Scene& scene) {
  std::set<std::string_view> first;
  for (const SceneLayer& layer : scene.layers) {
    if (layer.visible) first.insert(store_at(layer, first_step(scene)));
  }
  return first;
}

/// BundleBytes::first_bytes.
uint64_t first_bytes_of(const Scene& scene, const BundleHeader& header) {
  const std::set<std::string_view> first = first_stores(scene);
  uint64_t end = header.header_bytes;
  for (const BundleStore& store : header.stores) {
    const uint64_t store_end = store.coarse_offset + store.coarse_bytes();
    if (first.contains(store.path) &&
        store_end - header.header_bytes <= BundleBytes::kMaxFirstCoarseBytes) {
      end = std::max(end, store_end);
    }
  }
  return end;
}

}  // namespace

Result<BundleBytes> BundleBytes::plan(const SceneFile& scene,
                                      const std::optional<fs::path>& within) {
  BundleBytes result;
  const auto identity = scene.file()->identity();
  if (!identity) return tl::unexpected(identity.error());
  result.scene_ = {scene.path(), *identity};
  if (scene.is_bundle()) {
    result.header_ = scene.bundle();
    result.first_bytes_ = first_bytes_of(scene.scene(), result.header_);
    result.bundle_ = scene.file();
    result.encoded_.resize(result.header_.header_bytes);
    if (auto read = result.bundle_->read(0, result.encoded_); !read) {
      return tl::unexpected(read.error());
    }
    return result;
  }
  const uint64_t of_each =
      kFirstPictureBytes / std::max<size_t>(1, first_stores(scene.scene()).size());
  std::vector<BundleStore> stores;
  for (const std::string& path : store_paths(scene.scene())) {
    if (!is_path_below(path) || path == kSceneName) {
      return fail(Status::malformed_header,
                  fmt::format("store {}: expected a store in the folder of the scene or below: "
                              "copy the store there, and name it by its relative path",
                              path));
    }
    const fs::path file = scene.path().parent_path() / path;
    std::optional<FileIdentity> inside;
    if (within && !(inside = identity_within(file, *within))) {
      return fail(Status::malformed_header,
                  fmt::format("store {}: expected a file in the folder of the scene or below, "
                              "found none, or a link out of it: copy the store there",
                              path));
    }
    const auto opened = scene.open_store(path);  // checks the header and the size
    if (!opened) return tl::unexpected(opened.error());
    const StoreFile& store = **opened;
    if (inside && !(store.identity() == *inside)) return tl::unexpected(changed(file.string()));
    BundleStore entry;
    entry.path = path;
    entry.file_bytes = store.info().file_bytes;
    entry.header_bytes = store.info().header_bytes;
    const uint64_t levels = of_each - std::min<uint64_t>(of_each, entry.header_bytes);
    const CoarseRange coarse = store.bootstrap_within(std::min(kBootstrapBytes, levels));
    entry.bootstrap_offset = coarse.offset;
    entry.bootstrap_bytes = coarse.bytes;
    entry.content_id = store.info().content_id;
    stores.push_back(std::move(entry));
    result.files_.push_back({file, store.identity()});
  }
  auto header = plan_bundle(scene.text(), std::move(stores));
  if (!header) return tl::unexpected(header.error());
  result.header_ = std::move(*header);
  result.first_bytes_ = first_bytes_of(scene.scene(), result.header_);
  result.encoded_ = encode_bundle_header(result.header_);
  for (size_t i = 0; i < result.files_.size(); ++i) {
    for (const BundlePiece& piece : result.header_.stores[i].pieces()) {
      result.pieces_.push_back(
          {piece.bundle_offset, piece.bundle_offset + piece.bytes, piece.store_offset, i});
    }
  }
  std::sort(result.pieces_.begin(), result.pieces_.end(),
            [](const Piece& a, const Piece& b) { return a.begin < b.begin; });
  return result;
}

std::string BundleBytes::content() const {
  uint64_t checksum = 0;
  for (size_t i = 0; i < 8; ++i) {
    checksum |= std::to_integer<uint64_t>(encoded_[encoded_.size() - 8 + i]) << (8 * i);
  }
  return fmt::format("{:016x}", checksum);
}

Result<void> BundleBytes::read(uint64_t offset, std::span<std::byte> out, NoWait* no_wait) const {
  if (offset > bytes() || out.size() > bytes() - offset) {
    return fail(Status::truncated, fmt::format("{}: expected {} bytes at {}, found {} bytes in all",
                                               scene_.path.string(), out.size(), offset, bytes()));
  }
  if (offset < encoded_.size()) {
    const size_t count = std::min<uint64_t>(out.size(), encoded_.size() - offset);
    std::memcpy(out.data(), encoded_.data() + offset, count);
    out = out.subspan(count);
    offset += count;
  }
  if (out.empty()) return {};
  if (bundle_) {
    const auto now = bundle_->identity(no_wait);
    if (!now) return tl::unexpected(now.error());
    if (!now->has_same_content(scene_.identity)) return tl::unexpected(changed(bundle_->name()));
    return bundle_->read(offset, out, no_wait);
  }
  auto piece = std::upper_bound(pieces_.begin(), pieces_.end(), offset,
                                [](uint64_t at, const Piece& each) { return at < each.end; });
  for (; !out.empty(); ++piece) {
    const size_t count = std::min<uint64_t>(out.size(), piece->end - offset);
    if (auto read = read_piece(*piece, offset, out.first(count), no_wait); !read) return read;
    out = out.subspan(count);
    offset += count;
  }
  return {};
}

/// Opens the file for each read, since a scene may have more stores than a process may have open
/// files.
Result<void> BundleBytes::read_piece(const Piece& piece, uint64_t offset, std::span<std::byte> out,
                                     NoWait* no_wait) const {
  const File& from = files_[piece.file];
  if (no_wait) {
    no_wait->needs_disk = true;
    return fail(Status::io_error, from.path.string() + ": is not open");
  }
  const auto file = PosixFile::open(from.path);
  if (!file) return tl::unexpected(file.error());
  const auto identity = file->identity();
  if (!identity) return tl::unexpected(identity.error());
  if (!(*identity == from.identity)) return tl::unexpected(changed(from.path.string()));
  return file->read(piece.file_offset + (offset - piece.begin), out);
}

bool BundleBytes::is_current() const {
  const auto is_same = [](const File& file) {
    const auto identity = file_identity(file.path);
    return identity && *identity == file.identity;
  };
  return is_same(scene_) && std::all_of(files_.begin(), files_.end(), is_same);
}

}  // namespace isosplat
