#include "server/catalog/catalog.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <system_error>
#include <utility>

#include "server/catalog/thumbnail.h"

namespace isosplat::server {
namespace {

namespace fs = std::filesystem;

/// The maximum depth of nested folders. It bounds the work of a scan.
constexpr int kMaxDepth = 32;

/// If there are more stores than this, the first scan logs one line for all.
constexpr size_t kManyStores = 100;

/// Some files are created without a report of their completion, for example by a link to a nameless
/// file. Such a file counts as complete once nobody has written to it for this long.
constexpr std::chrono::seconds kSettled{2};

bool is_listed_name(std::string_view name) {
  return is_listed(name, ServedKind::volume) || is_listed(name, ServedKind::scene);
}

/// Whether a name in a folder is that of a subfolder, if `is_folder`. A folder whose name is that
/// of a store is a store that cannot be read.
bool is_subfolder(std::string_view name, bool is_folder) {
  return is_folder && !is_listed(name, ServedKind::volume);
}

fs::path real_path(const fs::path& path) {
  std::error_code ignored;
  return fs::weakly_canonical(fs::absolute(path, ignored), ignored);
}

/// The identity of the folder at a path; null if there is none.
std::optional<FileIdentity> folder_identity(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) return std::nullopt;
  return FileIdentity{static_cast<uint64_t>(status.st_dev), static_cast<uint64_t>(status.st_ino), 0,
                      0};
}

/// Whether the error is temporary, so that the same folder may be readable a moment later.
bool is_passing(const std::error_code& error) {
  const int code = error.value();
  return code == EMFILE || code == ENFILE || code == EIO || code == ENOMEM || code == EINTR;
}

bool exists(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0;
}

bool is_real_folder(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode);
}

}  // namespace

Catalog::Catalog(const std::vector<fs::path>& sources, Log log, OutsideLinks links)
    : sources_(named_sources(sources)),
      log_(std::move(log)),
      stores_(ServedKind::volume, log_, links),
      scenes_(ServedKind::scene, log_, links),
      store_snapshot_(std::make_shared<CatalogSnapshot>()),
      scene_snapshot_(store_snapshot_) {}

std::shared_ptr<const CatalogSnapshot> Catalog::snapshot(ServedKind kind) const {
  const std::lock_guard lock(snapshot_mutex_);
  return kind == ServedKind::volume ? store_snapshot_ : scene_snapshot_;
}

CatalogEntries& Catalog::entries_of(const std::string& path) {
  const size_t name = path.find_last_of('/') + 1;  // 0 if there is none
  return is_scene_file(std::string_view(path).substr(name)) ? scenes_ : stores_;
}

void Catalog::renew_scenes(const std::vector<fs::path>& paths) {
  const std::lock_guard lock(mutex_);
  for (const fs::path& path : paths) scenes_.renew(path.string());
  publish_snapshots();
}

void Catalog::scan() {
  const std::scoped_lock lock(follow_mutex_, mutex_);
  scan_now();
  publish_snapshots();
}

bool Catalog::follow(std::chrono::milliseconds longest) {
  const std::lock_guard follow_lock(follow_mutex_);
  const FolderWatch::Changes changes = watch_.wait(longest);
  const std::lock_guard lock(mutex_);
  // Where changes are not reported, scanning may take at most a twentieth of the time.
  const bool is_due = !is_all_watched_ && Clock::now() - last_scan_ > 20 * scan_time_;
  if (changes.is_incomplete || is_due || are_sources_replaced()) {
    scan_now();
  } else {
    for (const FolderChange& change : changes.list) apply(change);
    look_at_unwatched();
  }
  return publish_snapshots();
}

// ---- Listing ----

void Catalog::scan_now() {
  const Clock::time_point begin = Clock::now();
  is_all_watched_ = true;
  is_full_ = false;
  unwatched_files_.clear();
  begun_.clear();
  source_folders_.clear();
  const std::map<std::string, StoreFolder> before = std::move(folders_);
  folders_.clear();
  FoundStores found;
  for (const NamedSource& source : sources_) list_source(source, found);
  for (const auto& [path, folder] : before) {
    if (!folders_.contains(path)) watch_.remove(path);
  }
  const bool are_many = is_first_scan_ && found.size() > kManyStores;
  if (are_many) log_(fmt::format("found {} stores and scenes", found.size()));
  // Sorted, so that names do not depend on the order in which a folder lists its files.
  for (const auto& [path, folder] : found) look_at(path, *folder);
  stores_.forget_all_but(found);
  scenes_.forget_all_but(found);
  is_first_scan_ = false;
  last_scan_ = Clock::now();
  scan_time_ = last_scan_ - begin;
}

void Catalog::list_source(const NamedSource& source, FoundStores& found) {
  const std::string path = source.path.string();
  StoreFolder folder;
  if (!source.label.empty()) {
    folder.segments = {source.label};
    folder.unaltered = {source.unaltered};
  }
  if (!source.is_folder) {
    // Only links to its folder are resolved, since the file itself may be a link.
    const fs::path absolute = fs::absolute(source.path);
    folder.canonical = folder.root = real_path(absolute.parent_path()).string();
    const auto [listed, is_new] = folders_.try_emplace("file " + path, std::move(folder));
    found.emplace(path, &listed->second);
    unwatched_files_.insert(path);
    return;
  }
  const auto identity = folder_identity(source.path);
  if (!identity) {
    is_all_watched_ = false;
    return report_folder(path, "expected a folder of stores, found none");
  }
  source_folders_.emplace(path, *identity);
  folder.canonical = folder.root = real_path(source.path).string();
  list_folder(path, std::move(folder), found);
}

/// Logs an error of a folder, unless it was logged before; an empty message: no error.
void Catalog::report_folder(const std::string& path, const std::string& message) {
  std::string& last = folder_errors_[path];
  if (message != last && !message.empty()) log_(fmt::format("folder {}: {}", path, message));
  last = message;
  if (last.empty()) folder_errors_.erase(path);
}

void Catalog::list_folder(const std::string& path, StoreFolder its, FoundStores& found) {
  const auto [folder, is_new] = folders_.try_emplace(path, std::move(its));
  if (!is_new) return;  // two sources contain it
  // Watch the folder before its files are listed, so that changes in between are reported.
  if (!watch_.add(path)) is_all_watched_ = false;
  std::error_code error;
  fs::directory_iterator file(path, error);
  for (; !error && file != fs::directory_iterator(); file.increment(error)) {
    const std::string name = file->path().filename().string();
    if (name.starts_with('.')) continue;
    std::error_code ignored;
    const bool is_link = file->is_symlink(ignored);
    const bool is_folder = !is_link && file->is_directory(ignored);
    if (is_listed_name(name) && !is_subfolder(name, is_folder)) {
      if (found.size() >= kMaxStores) {
        is_full_ = true;
        break;
      }
      found.emplace(file->path().string(), &folder->second);
      if (is_link) unwatched_files_.insert(file->path().string());
    } else if (is_folder && folder->second.depth < kMaxDepth) {
      list_folder(file->path().string(), folder->second.below(name), found);
    }
  }
  if (error && is_passing(error)) {
    // Its stores stay in the catalog, and the next scan lists the folder.
    is_all_watched_ = false;
    stores_.find_below(path, folder->second, found);
    scenes_.find_below(path, folder->second, found);
  }
  std::string message = error ? std::strerror(error.value()) : std::string();
  if (is_full_)
    message = fmt::format("more than {} stores and scenes: the others are not served", kMaxStores);
  report_folder(path, message);
}

void Catalog::look_at(const std::string& path, const StoreFolder& folder) {
  CatalogEntries& entries = entries_of(path);
  entries.look_at(path, folder, is_first_scan_ && entries.size() >= kManyStores);
}

// ---- Following changes ----

void Catalog::apply(const FolderChange& change) {
  const auto folder = folders_.find(change.folder);
  if (folder == folders_.end() || change.name.starts_with('.')) return;
  const std::string path = (fs::path(change.folder) / change.name).string();
  if (change.name.ends_with(kThumbnailExtension)) {
    const std::string shown = path.substr(0, path.size() - kThumbnailExtension.size());
    if (entries_of(shown).contains(shown)) return look_at(shown, folder->second);
  }
  const bool is_folder = change.kind == FolderChange::Kind::folder;
  if (!is_listed_name(change.name) || is_subfolder(change.name, is_folder)) {
    if (!is_folder) return;
    const bool has_source = std::ranges::any_of(sources_, [&](const NamedSource& source) {
      return (source.path.string() + '/').starts_with(path + '/');
    });
    if (has_source) return scan_now();
    return renew_folder(path, folder->second, change.name);
  }
  struct stat status {};
  const bool is_there = ::lstat(path.c_str(), &status) == 0;
  const bool is_link = is_there && S_ISLNK(status.st_mode);
  if (is_link) {
    unwatched_files_.insert(path);
  } else {
    unwatched_files_.erase(path);
  }
  const bool may_grow = is_there && S_ISREG(status.st_mode) && status.st_nlink == 1;
  if (change.kind == FolderChange::Kind::begun && may_grow) {
    begun_.insert(path);
    return;
  }
  begun_.erase(path);
  if (is_there) {
    look_at(path, folder->second);
  } else {
    entries_of(path).forget(path);
  }
}

/// Lists a folder again that appeared, disappeared, or was renamed.
void Catalog::renew_folder(const std::string& path, const StoreFolder& parent,
                           const std::string& name) {
  const std::string below = path + '/', end = path + static_cast<char>('/' + 1);
  watch_.remove(path);
  folders_.erase(path);
  folders_.erase(folders_.lower_bound(below), folders_.lower_bound(end));
  FoundStores found;
  if (is_real_folder(path) && parent.depth < kMaxDepth) {
    list_folder(path, parent.below(name), found);
  }
  stores_.forget_below_but(path, found);
  scenes_.forget_below_but(path, found);
  for (const auto& [file, folder] : found) look_at(file, *folder);
}

/// Examines files whose changes are not reported, and files whose writing has ended without a
/// report.
void Catalog::look_at_unwatched() {
  const auto folder_of = [this](const std::string& path) {
    const auto source = folders_.find("file " + path);
    return source != folders_.end() ? source : folders_.find(fs::path(path).parent_path().string());
  };
  for (auto path = unwatched_files_.begin(); path != unwatched_files_.end();) {
    const auto folder = folder_of(*path);
    const bool is_source = folder != folders_.end() && folder->first.starts_with("file ");
    if (folder == folders_.end() || (!is_source && !exists(*path))) {
      entries_of(*path).forget(*path);
      path = unwatched_files_.erase(path);
      continue;
    }
    look_at(*path, folder->second);
    ++path;
  }
  for (auto path = begun_.begin(); path != begun_.end();) {
    struct stat status {};
    const bool is_there = ::lstat(path->c_str(), &status) == 0;
    const auto age =
        std::chrono::system_clock::now() - std::chrono::system_clock::from_time_t(status.st_mtime);
    if (is_there && age < kSettled) {
      ++path;
      continue;
    }
    const auto folder = folder_of(*path);
    if (is_there && folder != folders_.end()) look_at(*path, folder->second);
    path = begun_.erase(path);
  }
}

/// Whether a folder of the sources appeared, disappeared, or was replaced.
bool Catalog::are_sources_replaced() const {
  return std::ranges::any_of(sources_, [this](const NamedSource& source) {
    if (!source.is_folder) return false;
    const auto known = source_folders_.find(source.path.string());
    const auto identity = folder_identity(source.path);
    return identity.has_value() != (known != source_folders_.end()) ||
           (identity && !(*identity == known->second));
  });
}

bool Catalog::publish_snapshots() {
  auto stores = stores_.changed_snapshot();
  auto scenes = scenes_.changed_snapshot();
  if (!stores && !scenes) return false;
  const std::lock_guard lock(snapshot_mutex_);
  if (stores) store_snapshot_ = std::move(stores);
  if (scenes) scene_snapshot_ = std::move(scenes);
  return true;
}

}  // namespace isosplat::server
