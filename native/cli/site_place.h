#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <span>
#include <string_view>
#include <vector>

#include "native/cli/site_source.h"

namespace isosplat::cli {

inline constexpr const char* kCatalogFile = "catalog.json";
inline constexpr const char* kIndexFile = "index.html";
/// The first bytes of the catalog of every site.
inline constexpr std::string_view kCatalogBeginning = "{\"isosplat\":\"site ";

/// A file of the built page, and its path in the site.
struct PageFile {
  std::filesystem::path source, relative;
};

/// Where a static site is written: a folder (SiteFolder) or a bucket (SiteBucket). Paths are
/// relative to the site, with slashes.
class SitePlace {
 public:
  using Path = std::filesystem::path;

  virtual ~SitePlace() = default;

  /// Checks that the site may be written: the place has a site, or nothing that the site would
  /// replace. `force`: it may have anything. Errors: invalid_argument, io_error.
  virtual Result<void> check(std::span<const PageFile> page, bool force) = 0;

  /// Whether a file of this machine lies in the site.
  virtual bool contains(const Path& file) const = 0;

  /// Errors: invalid_argument if the output is one of these files of this machine.
  virtual Result<void> check_not_input(const Path& output, std::span<const Path> inputs) const = 0;

  /// Whether the site needs a file of the page.
  virtual bool wants(const Path& page_file) const = 0;

  /// Whether the site has this store or scene, whose name has its content id. Errors: io_error.
  virtual Result<bool> has(const Path& path, const SiteSource& source) = 0;

  /// Writes a file, which appears when it is complete. Errors: io_error.
  virtual Result<void> write(const Path& path, std::span<const std::byte> bytes) = 0;

  /// Writes a store or a scene. Calls copied(bytes) for parts of it. Errors: io_error, also if its
  /// files were changed after it was opened.
  virtual Result<void> copy(const Path& path, const SiteSource& source,
                            const std::function<void(uint64_t bytes)>& copied) = 0;

  /// Errors: invalid_argument if this place does not implement prune().
  virtual Result<void> check_prune() const = 0;

  /// Removes stores, scenes and assets except those to keep, and returns them. Never removes one of
  /// the inputs. Errors: io_error; those of check_prune().
  virtual Result<std::vector<Path>> prune(const std::set<Path>& kept,
                                          std::span<const Path> inputs) = 0;
};

}  // namespace isosplat::cli
