#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/catalog/store_summary.h"
#include "server/catalog/volume_names.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat::server {

/// The maximum number of stores and scenes that are served. It bounds the work of a scan.
inline constexpr size_t kMaxStores = 100'000;

/// The file of a store or a scene, as of its last examination. If the file or its thumbnail is
/// replaced or modified, a new entry replaces this one.
struct CatalogEntry : VolumeIdentity {
  uint64_t id = 0;   ///< of this entry; never used again
  std::string name;  ///< as in URLs: segments of letters, digits, "-", "_" and ".", and "~" between
                     ///< them; unique
  std::filesystem::path path;
  std::string root;               ///< the folder of its source, absolute, with links resolved
  std::string content_before;     ///< the last content id of this path; empty: not known
  bool must_be_identity = false;  ///< the opened file must be the file of `identity`
  std::optional<FileIdentity> identity;   ///< absent: there is no such file, or it is not a file
  std::optional<FileIdentity> thumbnail;  ///< of the picture beside it; absent: none
  bool is_one_of_many = false;            ///< found with many others: not logged in a separate line
  SummaryCell summary;                    ///< a summary of its header, once it has been read
};

/// The files of one kind at one moment, by name. Each request uses one snapshot from beginning to
/// end.
using CatalogSnapshot = std::map<std::string, std::shared_ptr<const CatalogEntry>, std::less<>>;

/// A folder with stores or scenes.
struct StoreFolder {
  std::vector<std::string> segments;   ///< of the names of its stores
  std::vector<std::string> unaltered;  ///< the same, as they are on the disk
  std::string canonical;               ///< absolute, with links resolved
  std::string root;                    ///< of its source, in the same way
  int depth = 0;                       ///< below the source

  /// A folder in this one.
  StoreFolder below(const std::string& name) const;
};

/// Files of stores and scenes that a listing found, by path, with the folder that they are in.
using FoundStores = std::map<std::string, const StoreFolder*>;

/// The entries of the existing files of one kind. The caller lists files and reports changes. Not
/// thread-safe.
class CatalogEntries {
 public:
  using Log = std::function<void(std::string_view)>;

  /// Whether links to files outside of the folders of the sources are followed.
  enum class OutsideLinks { followed, refused };

  CatalogEntries(ServedKind kind, Log log, OutsideLinks links);

  size_t size() const { return entries_.size(); }
  bool contains(const std::string& path) const { return entries_.contains(path); }

  /// Adds an entry for a file that is new or was replaced. Logs a link that is not followed, once.
  void look_at(const std::string& path, const StoreFolder& folder, bool is_one_of_many);

  /// Replaces an entry, if it exists, by a new one for the same file: a file that it refers to has
  /// changed.
  void renew(const std::string& path);

  /// Removes the entry of a path, if there is one, and logs this.
  void forget(const std::string& path);

  /// Removes the entries that were not found.
  void forget_all_but(const FoundStores& found);

  /// Removes the entries below a folder that were not found.
  void forget_below_but(const std::string& path, const FoundStores& found);

  /// Adds the files below a folder to those that were found.
  void find_below(const std::string& path, const StoreFolder& folder, FoundStores& found) const;

  /// The entries by name; null if no entry has changed since the last call. Logs files that are
  /// left out because of their names.
  std::shared_ptr<const CatalogSnapshot> changed_snapshot();

 private:
  using ByPath = std::map<std::string, std::shared_ptr<const CatalogEntry>>;

  std::optional<FileIdentity> look_at_link(const std::string& path, const StoreFolder& folder);
  void forget(ByPath::iterator entry);
  void forget_range(ByPath::iterator begin, ByPath::iterator end, const FoundStores& found);

  const ServedKind kind_;
  const Log log_;
  const OutsideLinks links_;
  uint64_t last_id_ = 0;
  ByPath entries_;
  std::set<std::string> refused_;  ///< paths that are not served, and were logged
  std::map<std::string, std::string> removed_content_;  ///< the last content of removed paths
  bool has_changed_ = true;
};

}  // namespace isosplat::server
