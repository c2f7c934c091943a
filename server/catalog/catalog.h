#pragma once

#include <chrono>
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

#include "server/catalog/folder_watch.h"
#include "server/catalog/store_summary.h"
#include "server/catalog/volume_names.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat::server {

/// A store file as it was when it was last looked at. A file that was replaced or modified, or
/// whose thumbnail was, has another entry.
struct CatalogEntry : VolumeIdentity {
  uint64_t id = 0;   ///< of this entry; never used again
  std::string name;  ///< as in URLs: segments of letters, digits, "-", "_" and ".", and "~" between
                     ///< them; unique
  std::filesystem::path path;
  std::string content_before;             ///< the last content id of this path; empty: not known
  bool must_be_identity = false;          ///< what is opened must be the file of `identity`
  std::optional<FileIdentity> identity;   ///< absent: there is no such file, or it is not a file
  std::optional<FileIdentity> thumbnail;  ///< of the picture beside it; absent: none
  bool is_one_of_many = false;            ///< found with many others: not worth a line in the log
  SummaryCell summary;                    ///< what its header says, once somebody has read it
};

/// The stores at one moment, by name. Each request uses one snapshot from begin to end.
using CatalogSnapshot = std::map<std::string, std::shared_ptr<const CatalogEntry>, std::less<>>;

/// The store files of a list of files and folders. Opens none of them.
class Catalog {
 public:
  using Log = std::function<void(std::string_view)>;

  /// Whether links to stores outside of the folders of `sources` are followed.
  enum class OutsideLinks { followed, refused };

  /// `sources`: store files, and folders with *.isosplat files in them and in their subfolders,
  /// named as named_sources() says. Files and folders whose names begin with "." are left out, and
  /// links to folders are not followed. Looks at nothing but the kinds of the sources before the
  /// first scan().
  Catalog(const std::vector<std::filesystem::path>& sources, Log log,
          OutsideLinks links = OutsideLinks::followed);

  /// Looks at all sources. Errors do not end a scan: they are logged once. Waits for a follow() in
  /// progress. Thread-safe.
  void scan();

  /// Waits for changes, but not longer than this and not after wake(), and applies them: files that
  /// were renamed to their place or closed by who wrote them, their thumbnails, and folders that
  /// came, went or were renamed. Files that are named as sources, links, and folders whose changes
  /// the system does not report are looked at in each call. Returns whether the snapshot has
  /// changed. Thread-safe.
  bool follow(std::chrono::milliseconds longest);

  /// Ends the wait of follow(). Thread-safe.
  void wake() { watch_.wake(); }

  std::shared_ptr<const CatalogSnapshot> snapshot() const;

 private:
  using Clock = std::chrono::steady_clock;

  /// A folder that was listed.
  struct Folder {
    std::vector<std::string> segments;   ///< of the names of its stores
    std::vector<std::string> unaltered;  ///< the same, as they are on the disk
    std::string canonical;               ///< absolute, with links resolved
    std::string root;                    ///< of its source, in the same way
    int depth = 0;                       ///< below the source

    /// A folder in this one.
    Folder below(const std::string& name) const;
  };

  /// Store files that a listing found, by path, with the folder that they are in.
  using Found = std::map<std::string, const Folder*>;

  void scan_now();
  void list_source(const NamedSource& source, Found& found);
  void list_folder(const std::string& path, Folder folder, Found& found);
  void report_folder(const std::string& path, const std::string& message);
  void keep_stores(const std::string& path, const Folder& folder, Found& found);
  void look_at(const std::string& path, const Folder& folder);
  std::optional<FileIdentity> look_at_link(const std::string& path, const Folder& folder);
  void forget(std::map<std::string, std::shared_ptr<const CatalogEntry>>::iterator store);
  void apply(const FolderChange& change);
  void renew_folder(const std::string& path, const Folder& parent, const std::string& name);
  void look_at_unwatched();
  bool are_sources_replaced() const;
  bool publish_snapshot();

  const std::vector<NamedSource> sources_;
  const Log log_;
  const OutsideLinks links_;

  std::mutex follow_mutex_;  // before mutex_
  FolderWatch watch_;        // guarded by follow_mutex_, except for wake()
  std::mutex mutex_;         // guards what follows, as far as snapshot_mutex_
  uint64_t last_id_ = 0;
  std::map<std::string, Folder> folders_;  ///< by path; that of a file source by "file " + path
  std::map<std::string, std::shared_ptr<const CatalogEntry>> stores_;  ///< by path
  std::set<std::string> unwatched_files_;               ///< links, and sources that are files
  std::set<std::string> begun_;                         ///< created, and perhaps not complete
  std::map<std::string, FileIdentity> source_folders_;  ///< device and inode of each
  std::map<std::string, std::string> folder_errors_;
  std::set<std::string> refused_;            ///< paths that are not served, and were logged
  std::map<std::string, std::string> gone_;  ///< the last content of paths that are gone
  bool is_all_watched_ = true;
  bool is_full_ = false;  ///< the limit of stores was reached
  bool has_changed_ = true;
  bool is_first_scan_ = true;
  Clock::time_point last_scan_{};
  Clock::duration scan_time_{};

  mutable std::mutex snapshot_mutex_;
  std::shared_ptr<const CatalogSnapshot> snapshot_;  // guarded by snapshot_mutex_
};

}  // namespace isosplat::server
