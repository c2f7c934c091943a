#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/core/scene/bundle_header.h"
#include "shared/system/posix_file/posix_file.h"
#include "shared/system/scene_file/scene_file.h"

namespace isosplat {

/// The bytes of a bundle (BUNDLE.md). If the scene is a document with separate stores, they are
/// those of a bundle of this scene and its stores: it is planned from the headers of the stores,
/// each read maps its range to the files of the stores, and nothing is copied. Several threads may
/// read at the same time.
class BundleBytes {
 public:
  /// Reads the headers of all stores, unless the scene is a bundle. The coarse part of each store
  /// contains its StoreReader::bootstrap_range. If many stores share the first picture, this range
  /// is limited to the store's share of kFirstPictureBytes. `within`: a folder that must contain
  /// the files of all stores once links are resolved; none: links are followed anywhere. Errors:
  /// those of SceneFile::open_store and plan_bundle; malformed_header if a store is not below the
  /// folder of its scene, or not in `within`.
  static Result<BundleBytes> plan(const SceneFile& scene,
                                  const std::optional<std::filesystem::path>& within = {});

  const BundleHeader& header() const { return header_; }
  uint64_t bytes() const { return header_.file_bytes; }

  /// The number of bytes at the beginning that a viewer reads first: the header, and the coarse
  /// parts up to the last one that the first picture needs. The first picture needs those of
  /// visible layers at the first step. At most kMaxFirstCoarseBytes of coarse parts.
  uint64_t first_bytes() const { return first_bytes_; }
  static constexpr uint64_t kMaxFirstCoarseBytes = uint64_t{32} << 20;
  /// The limit for the headers and levels of all stores of the first picture. Their coarsest levels
  /// may exceed it.
  static constexpr uint64_t kFirstPictureBytes = uint64_t{448} << 10;

  /// Whether the stores are separate files, which may change independently of the scene.
  bool has_separate_stores() const { return !bundle_; }

  /// The document or the bundle that was opened.
  const FileIdentity& scene_identity() const { return scene_.identity; }

  /// The checksum of the header, as 16 hexadecimal digits. It covers the scene and the content ids
  /// of all stores, so another content has another checksum.
  std::string content() const;

  /// Fills `out` with the bytes at `offset`. Errors: io_error, also for a file that was replaced or
  /// modified since plan(); truncated if there are fewer bytes.
  Result<void> read(uint64_t offset, std::span<std::byte> out, NoWait* no_wait = nullptr) const;

  /// Whether no file was replaced, modified or removed since plan(). Examines all files by their
  /// paths, and may wait for the disk.
  bool is_current() const;

 private:
  struct File {
    std::filesystem::path path;
    FileIdentity identity;
  };
  struct Piece {
    uint64_t begin = 0, end = 0;  ///< in the bundle
    uint64_t file_offset = 0;
    size_t file = 0;  ///< index into files_
  };

  BundleBytes() = default;
  Result<void> read_piece(const Piece& piece, uint64_t offset, std::span<std::byte> out,
                          NoWait* no_wait) const;

  BundleHeader header_;
  std::vector<std::byte> encoded_;  ///< the header
  uint64_t first_bytes_ = 0;
  std::vector<File> files_;    ///< of the stores; none if the scene is a bundle
  std::vector<Piece> pieces_;  ///< ascending, without gaps, from the end of the header on
  std::shared_ptr<const RandomAccessFile> bundle_;  ///< null: the stores are separate files
  File scene_;                                      ///< the document, or the bundle
};

}  // namespace isosplat
