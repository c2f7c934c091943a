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

/// A store that is served, or the reason why it is not.
struct CatalogEntry {
  std::string name;  ///< as in URLs: letters, digits, "-", "_" and "."; unique
  std::filesystem::path path;
  std::optional<FileIdentity> identity;  ///< of the file when it was tried
  std::shared_ptr<const StoreFile> store;
  std::optional<Error> error;  ///< exactly where there is no store
};

/// The stores at one moment. Requests work on one snapshot from begin to end.
using CatalogSnapshot = std::map<std::string, CatalogEntry, std::less<>>;

/// The stores of a list of files and folders, followed as they come, change and go.
class Catalog {
 public:
  using Log = std::function<void(std::string_view)>;

  /// `sources`: store files, and folders whose *.isosplat files are taken (not those of their
  /// subfolders). Nothing is opened before the first scan().
  Catalog(std::vector<std::filesystem::path> sources, uint64_t directory_bytes, Log log);

  /// Opens what is new or was replaced, and forgets what is gone. A name stays with its path for
  /// the catalog's life. Errors do not end a scan: they are logged once, and kept in the entry.
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
  std::set<std::string> taken_;                                 // guarded by scan_mutex_
  std::map<std::filesystem::path, std::string> folder_errors_;  // guarded by scan_mutex_

  mutable std::mutex snapshot_mutex_;
  std::shared_ptr<const CatalogSnapshot> snapshot_;  // guarded by snapshot_mutex_
};

/// A name for URLs from a file name: its stem, each run of other characters than letters, digits,
/// "-", "_" and "." made one "-", without "." in front. Never empty.
std::string url_name(const std::filesystem::path& path);

}  // namespace isosplat
