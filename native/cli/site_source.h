#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "server/catalog/scene_json.h"
#include "server/catalog/volume_names.h"
#include "shared/core/base/status.h"
#include "shared/system/scene_file/bundle_bytes.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::cli {

/// A store or a scene that is published. A scene is published as a bundle.
class SiteSource {
 public:
  /// Errors: those of StoreFile::open, SceneFile::open and BundleBytes::plan.
  static Result<SiteSource> open(server::ServedKind kind, const std::filesystem::path& path);

  const std::string& content() const { return content_; }
  uint64_t bytes() const { return scene_ ? scene_->bytes() : store_->info().file_bytes; }

  /// Null for a scene.
  const StoreFile* store() const { return store_.get(); }
  /// Of a scene.
  const server::SceneFacts& facts() const { return facts_; }

  /// The stores of a scene document, which are separate files.
  const std::set<std::filesystem::path>& stores() const { return stores_; }

  /// Fills `out` with the bytes at `offset`. Errors: io_error, truncated.
  Result<void> read(uint64_t offset, std::span<std::byte> out) const;

  /// Fails if a file was changed after open(). Errors: io_error.
  Result<void> check_unchanged() const;

 private:
  SiteSource() = default;

  std::filesystem::path path_;
  std::string content_;
  std::shared_ptr<const StoreFile> store_;
  std::shared_ptr<const BundleBytes> scene_;
  server::SceneFacts facts_;
  std::set<std::filesystem::path> stores_;
};

}  // namespace isosplat::cli
