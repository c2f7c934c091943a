#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "shared/store_file/store_file.h"

namespace isosplat {

/// A store that is served, or the error why it is not.
struct CatalogEntry {
  std::string name;  ///< as in URLs: letters, digits, "-", "_" and "."; unique
  std::filesystem::path path;
  std::filesystem::path folder;          ///< of `path`; absolute, with links resolved
  std::optional<FileIdentity> identity;  ///< of the file when it was opened
  std::shared_ptr<const StoreFile> store;
  std::optional<Error> error;  ///< if and only if `store` is null
};

/// The stores at one moment, by name. Each request uses one snapshot from begin to end.
using CatalogSnapshot = std::map<std::string, CatalogEntry, std::less<>>;

/// The stores of a list of files and folders. Regular scans find new, changed and removed stores.
class Catalog {
 public:
  using Log = std::function<void(std::string_view)>;

  /// `sources`: store files, and folders with *.isosplat files (without their subfolders).
  /// `directory_bytes`: cache of directory pages per store. Opens no file before the first scan().
  Catalog(std::vector<std::filesystem::path> sources, uint64_t directory_bytes, Log log);

  /// Opens new and replaced stores, and drops removed ones. A path keeps its name for the lifetime
  /// of the catalog. Errors do not end a scan: they are logged once, and kept in the entry.
  void scan();

  std::shared_ptr<const CatalogSnapshot> snapshot() const;

 private:
  std::string name_for(const std::filesystem::path& path);
  CatalogEntry examine(const std::filesystem::path& path, const CatalogSnapshot& before);

  const std::vector<std::filesystem::path> sources_;
  const uint64_t directory_bytes_;
  const Log log_;

  std::mutex scan_mutex_;
  std::map<std::filesystem::path, std::string> names_;          // guarded by scan_mutex_
  std::set<std::string> used_names_;                            // guarded by scan_mutex_
  std::map<std::filesystem::path, std::string> folder_errors_;  // guarded by scan_mutex_

  mutable std::mutex snapshot_mutex_;
  std::shared_ptr<const CatalogSnapshot> snapshot_;  // guarded by snapshot_mutex_
};

/// The name of a store in URLs: the stem of its file name, in which each run of characters other
/// than letters, digits, "-", "_" and "." becomes one "-", without leading "." and "-". Never
/// empty.
std::string url_name(const std::filesystem::path& path);

}  // namespace isosplat
