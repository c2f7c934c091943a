#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "server/catalog/catalog_entries.h"
#include "server/catalog/folder_watch.h"
#include "server/catalog/volume_names.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat::server {

/// The stores and scenes of a list of files and folders. Opens none of them.
class Catalog {
 public:
  using Log = CatalogEntries::Log;
  using OutsideLinks = CatalogEntries::OutsideLinks;

  /// `sources`: files of stores and scenes, and folders with such files (is_listed) in them and in
  /// their subfolders. named_sources() determines the names. Files and folders whose names begin
  /// with "." are left out, and links to folders are not followed. Before the first scan(),
  /// examines only the kinds of the sources.
  Catalog(const std::vector<std::filesystem::path>& sources, Log log,
          OutsideLinks links = OutsideLinks::followed);

  /// Scans all sources. Errors do not end a scan: they are logged once. Waits for a follow() in
  /// progress. Thread-safe.
  void scan();

  /// Waits for changes, at most for this time and until wake(), and applies them: files that were
  /// renamed or closed by their writer, their thumbnails, and folders that appeared, disappeared or
  /// were renamed. Some changes are not reported by the system; each call therefore also examines
  /// files that are named as sources, links, and folders without reports. Returns whether the
  /// snapshot has changed. Thread-safe.
  bool follow(std::chrono::milliseconds longest);

  /// Ends the wait of follow(). Thread-safe.
  void wake() { watch_.wake(); }

  std::shared_ptr<const CatalogSnapshot> snapshot(ServedKind kind = ServedKind::volume) const;

  /// Replaces the entries of scenes whose stores have changed, by their paths: see
  /// CatalogEntries::renew. Thread-safe.
  void renew_scenes(const std::vector<std::filesystem::path>& paths);

 private:
  using Clock = std::chrono::steady_clock;

  void scan_now();
  void list_source(const NamedSource& source, FoundStores& found);
  void list_folder(const std::string& path, StoreFolder folder, FoundStores& found);
  void report_folder(const std::string& path, const std::string& message);
  void look_at(const std::string& path, const StoreFolder& folder);
  void apply(const FolderChange& change);
  void renew_folder(const std::string& path, const StoreFolder& parent, const std::string& name);
  void look_at_unwatched();
  bool are_sources_replaced() const;
  bool publish_snapshots();
  CatalogEntries& entries_of(const std::string& path);

  const std::vector<NamedSource> sources_;
  const Log log_;

  std::mutex follow_mutex_;  // before mutex_
  FolderWatch watch_;        // guarded by follow_mutex_, except for wake()
  std::mutex mutex_;         // guards the following members, up to snapshot_mutex_
  CatalogEntries stores_;
  CatalogEntries scenes_;
  /// By path; the key of a file source is "file " + path.
  std::map<std::string, StoreFolder> folders_;
  std::set<std::string> unwatched_files_;               ///< links, and sources that are files
  std::set<std::string> begun_;                         ///< created, and perhaps not complete
  std::map<std::string, FileIdentity> source_folders_;  ///< device and inode of each
  std::map<std::string, std::string> folder_errors_;
  bool is_all_watched_ = true;
  bool is_full_ = false;  ///< the limit of files was reached
  bool is_first_scan_ = true;
  Clock::time_point last_scan_{};
  Clock::duration scan_time_{};

  mutable std::mutex snapshot_mutex_;
  std::shared_ptr<const CatalogSnapshot> store_snapshot_;  // guarded by snapshot_mutex_
  std::shared_ptr<const CatalogSnapshot> scene_snapshot_;  // guarded by snapshot_mutex_
};

}  // namespace isosplat::server
