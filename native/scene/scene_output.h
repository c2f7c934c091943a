#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "shared/core/base/status.h"
#include "shared/core/scene/scene.h"

namespace isosplat {

/// The output of a build of several stores: a bundle (NAME.isobundle), or a folder with scene.json
/// and its stores. Stores are written one by one. If the build is interrupted, those that are
/// complete stay, and the next build of the same output uses them: in the folder itself, or for a
/// bundle in the hidden folder .NAME.isobundle.parts beside it, which finish() removes.
class SceneOutput {
 public:
  /// Whether a path names such an output rather than a store: it ends with .isobundle or "/".
  static bool is_scene(const std::filesystem::path& path);

  /// Checks that a scene with the names, times and stores of this one can be read: before its
  /// stores are built. Errors: those of parse_scene; invalid_argument (more stores than a bundle
  /// may have).
  static Result<void> check(const Scene& scene);

  /// `force`: replaces any file, and a scene that this class has not written. Errors:
  /// invalid_argument, io_error.
  static Result<SceneOutput> create(const std::filesystem::path& path, bool force);

  /// Where a store is to be written. `name`: of letters, digits, "-", "_" and ".".
  std::filesystem::path store_file(const std::string& name) const;
  /// The path of this store in the scene.
  static std::string store_path(const std::string& name);

  /// Whether an earlier build has completed this store. `key`: all that determines its bytes. Only
  /// its hash is written, since a folder may be published, and the key has paths.
  bool has(const std::string& name, const std::string& key) const;
  /// This store is complete. Errors: io_error.
  Result<void> completed(const std::string& name, const std::string& key);

  /// Writes the scene, whose stores are complete. A bundle, or the document in a folder, appears as
  /// a whole; the stores in a folder have been replaced one by one. Returns the bytes of all files.
  /// Errors: io_error, those of parse_scene and of write_bundle.
  Result<uint64_t> finish(const Scene& scene);

 private:
  SceneOutput() = default;

  std::filesystem::path path_, folder_;
  bool is_bundle_ = false;
  std::map<std::string, std::string> keys_;  ///< hashes of those of the complete stores
};

}  // namespace isosplat
