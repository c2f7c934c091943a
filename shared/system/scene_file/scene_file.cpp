#include "shared/system/scene_file/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "shared/system/posix_file/posix_file.h"

namespace isosplat {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kKindBytes = 256;

/// Puts the path in front of the message.
tl::unexpected<Error> at_path(const fs::path& path, Error error) {
  if (!error.message.starts_with(path.string()))
    error.message = path.string() + ": " + error.message;
  return tl::unexpected(std::move(error));
}

Result<std::string> read_text(const RandomAccessFile& file, uint64_t bytes) {
  std::string text(bytes, '\0');
  auto read = file.read(0, std::as_writable_bytes(std::span(text)));
  if (!read) return tl::unexpected(read.error());
  return text;
}

bool is_address(const std::string& path) {
  return path.find("://") != std::string::npos || path.starts_with("//");
}

}  // namespace

SceneKind scene_kind(const fs::path& path) {
  const auto file = PosixFile::open(path);
  if (!file) return SceneKind::none;
  const auto identity = file->identity();
  return identity ? scene_kind(*file, identity->bytes) : SceneKind::none;
}

SceneKind scene_kind(const RandomAccessFile& file, uint64_t bytes) {
  const auto first = read_text(file, std::min<uint64_t>(bytes, kKindBytes));
  if (!first) return SceneKind::none;
  if (is_bundle(std::as_bytes(std::span(*first)))) return SceneKind::bundle;
  return looks_like_scene(*first) ? SceneKind::scene : SceneKind::none;
}

Result<SceneFile> SceneFile::open(const fs::path& path) {
  auto file = PosixFile::open(path);
  if (!file) return tl::unexpected(file.error());
  const auto identity = file->identity();
  if (!identity) return tl::unexpected(identity.error());
  return open(std::make_shared<const PosixFile>(std::move(*file)), identity->bytes, path);
}

Result<SceneFile> SceneFile::open(std::shared_ptr<const RandomAccessFile> file, uint64_t bytes,
                                  const fs::path& path) {
  SceneFile result;
  result.path_ = path;
  result.file_ = std::move(file);
  const auto prefix = read_text(*result.file_, std::min<uint64_t>(bytes, kBundlePrefixBytes));
  if (!prefix) return tl::unexpected(prefix.error());
  const auto first = std::as_bytes(std::span(*prefix));
  if (isosplat::is_bundle(first)) {
    const auto header_bytes = bundle_header_bytes(first);
    if (!header_bytes) return at_path(path, header_bytes.error());
    if (*header_bytes > bytes) {
      return at_path(
          path,
          {Status::truncated,
           "bundle: expected the whole header, found the end of the file: copy the file again"});
    }
    const auto header = read_text(*result.file_, *header_bytes);
    if (!header) return tl::unexpected(header.error());
    auto parsed = parse_bundle_header(std::as_bytes(std::span(*header)));
    if (!parsed) return at_path(path, parsed.error());
    if (parsed->file_bytes != bytes) {
      return at_path(
          path, {parsed->file_bytes > bytes ? Status::truncated : Status::malformed_header,
                 fmt::format("bundle: expected a file of {} bytes, found {}: copy the file again",
                             parsed->file_bytes, bytes)});
    }
    result.text_ = parsed->scene;
    result.bundle_ = std::move(*parsed);
    for (size_t i = 0; i < result.bundle_->stores.size(); ++i) {
      result.in_bundle_[result.bundle_->stores[i].path] = i;
    }
  } else {
    if (bytes > kMaxSceneBytes) {
      return at_path(
          path,
          {Status::malformed_header,
           fmt::format("scene: expected at most {} bytes, found {}: divide it into several scenes",
                       kMaxSceneBytes, bytes)});
    }
    auto text = read_text(*result.file_, bytes);
    if (!text) return tl::unexpected(text.error());
    result.text_ = std::move(*text);
  }
  auto scene = parse_scene(result.text_);
  if (!scene) return at_path(path, scene.error());
  result.scene_ = std::move(*scene);
  if (!result.bundle_) return result;
  for (const std::string& store : store_paths(result.scene_)) {
    if (!result.in_bundle_.contains(store)) {
      return at_path(path, {Status::malformed_header,
                            fmt::format("bundle: expected the store {}, which its scene names, "
                                        "found none: make the bundle again",
                                        store)});
    }
  }
  return result;
}

Result<FileParts> SceneFile::store_bytes(const std::string& path) const {
  if (bundle_) {
    const auto found = in_bundle_.find(path);
    if (found == in_bundle_.end()) {
      return fail(
          Status::not_found,
          fmt::format("{}: expected the store {} in the bundle, found none", path_.string(), path));
    }
    std::vector<FileParts::Part> parts;
    for (const BundlePiece& piece : bundle_->stores[found->second].pieces()) {
      parts.push_back({piece.store_offset, piece.bundle_offset, piece.bytes});
    }
    return FileParts(file_, std::move(parts));
  }
  if (is_address(path)) {
    return fail(Status::malformed_header,
                fmt::format("{}: expected stores in files, found a store at the address {}: "
                            "download the store first, or open the scene in the page",
                            path_.string(), path));
  }
  auto file = PosixFile::open(path_.parent_path() / path);
  if (!file) return tl::unexpected(file.error());
  const auto identity = file->identity();
  if (!identity) return tl::unexpected(identity.error());
  return FileParts(std::make_shared<const PosixFile>(std::move(*file)), identity->bytes);
}

Result<std::shared_ptr<StoreFile>> SceneFile::open_store(const std::string& path) const {
  auto bytes = store_bytes(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return StoreFile::open(std::move(*bytes), bundle_ ? path_ / path : path_.parent_path() / path);
}

}  // namespace isosplat
