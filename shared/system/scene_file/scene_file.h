#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "shared/core/scene/bundle_header.h"
#include "shared/core/scene/scene.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {

/// The kinds of files that describe one picture.
enum class SceneKind : uint8_t {
  none,    ///< no scene
  scene,   ///< a document, beside its stores
  bundle,  ///< a scene and its stores in one file
};

/// Determines the kind from the first bytes: a document begins as JSON, whatever its name is.
SceneKind scene_kind(const std::filesystem::path& path);
/// The same for an open file of this many bytes.
SceneKind scene_kind(const RandomAccessFile& file, uint64_t bytes);

/// A scene and its stores on disk. Stores are opened when they are needed.
class SceneFile {
 public:
  /// Reads a scene or a bundle. Errors: io_error, those of parse_scene and parse_bundle_header, and
  /// malformed_header if a bundle lacks a store of its scene. Messages begin with the path.
  static Result<SceneFile> open(const std::filesystem::path& path);

  /// The same for an open file of this many bytes. `path`: for messages; of a document also the
  /// path of its folder, which has the stores.
  static Result<SceneFile> open(std::shared_ptr<const RandomAccessFile> file, uint64_t bytes,
                                const std::filesystem::path& path);

  const Scene& scene() const { return scene_; }
  /// The document, byte for byte.
  const std::string& text() const { return text_; }
  bool is_bundle() const { return bundle_.has_value(); }
  /// Requires is_bundle().
  const BundleHeader& bundle() const { return *bundle_; }

  const std::filesystem::path& path() const { return path_; }
  /// The opened file: the document, or the bundle.
  const std::shared_ptr<const RandomAccessFile>& file() const { return file_; }

  /// The bytes of a store of the scene. Errors: io_error, not_found. malformed_header for addresses
  /// (https://…): the program reads files only.
  Result<FileParts> store_bytes(const std::string& path) const;
  /// Opens a store of the scene. Errors: those of store_bytes() and StoreFile::open.
  Result<std::shared_ptr<StoreFile>> open_store(const std::string& path) const;

 private:
  SceneFile() = default;

  std::filesystem::path path_;
  Scene scene_;
  std::string text_;
  std::optional<BundleHeader> bundle_;
  std::shared_ptr<const RandomAccessFile> file_;  // the document or the bundle
  std::map<std::string, size_t> in_bundle_;
};

}  // namespace isosplat
