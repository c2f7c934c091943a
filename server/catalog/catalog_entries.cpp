#include "server/catalog/catalog_entries.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <iterator>
#include <system_error>
#include <utility>

#include "server/catalog/thumbnail.h"

namespace isosplat::server {
namespace {

namespace fs = std::filesystem;

/// The content of an entry, or the last known content of its path.
std::string content_of(const CatalogEntry& entry) {
  const auto summary = entry.summary.get();
  return summary && !summary->content.empty() ? summary->content : entry.content_before;
}

/// The end of the paths below a folder, in the order of paths.
std::string end_of(const std::string& folder) {
  return folder + static_cast<char>('/' + 1);
}

}  // namespace

StoreFolder StoreFolder::below(const std::string& name) const {
  StoreFolder folder = *this;
  folder.segments.push_back(name_segment(name));
  folder.unaltered.push_back(name);
  folder.canonical += '/' + name;
  ++folder.depth;
  return folder;
}

CatalogEntries::CatalogEntries(ServedKind kind, Log log, OutsideLinks links)
    : kind_(kind), log_(std::move(log)), links_(links) {}

void CatalogEntries::look_at(const std::string& path, const StoreFolder& folder,
                             bool is_one_of_many) {
  const auto old = entries_.find(path);
  std::optional<FileIdentity> identity;
  if (const Result<FileIdentity> known = file_identity(path)) identity = *known;
  struct stat status {};
  const bool is_link = ::lstat(path.c_str(), &status) == 0 && S_ISLNK(status.st_mode);
  const bool must_be_inside = is_link && links_ == OutsideLinks::refused;
  if (must_be_inside) {
    identity = look_at_link(path, folder);
    if (!identity) {
      if (old != entries_.end()) forget(old);
      return;
    }
  }
  std::optional<FileIdentity> thumbnail;
  if (const Result<FileIdentity> known = file_identity(thumbnail_path(path))) thumbnail = *known;
  if (old != entries_.end() && old->second->identity == identity &&
      old->second->thumbnail == thumbnail) {
    return;
  }
  if (old == entries_.end() && entries_.size() >= kMaxStores) return;
  auto entry = std::make_shared<CatalogEntry>();
  entry->id = ++last_id_;
  entry->kind = kind_;
  const std::string stem = stem_of_file(path), segment_of_stem = file_segment(path);
  for (const std::string& segment : folder.segments) entry->name += segment + kFolderSeparator;
  entry->name += segment_of_stem;
  entry->unaltered = folder.unaltered;
  entry->unaltered.push_back(stem);
  std::vector<std::string> segments = folder.segments;
  segments.push_back(segment_of_stem);
  if (segments == entry->unaltered) entry->unaltered = {};
  entry->folder = folder.canonical;
  entry->file = fs::path(path).filename().string();
  entry->path = path;
  entry->root = folder.root;
  entry->identity = identity;
  entry->thumbnail = thumbnail;
  entry->must_be_identity = must_be_inside;
  entry->is_one_of_many = is_one_of_many;
  if (old != entries_.end()) {
    entry->content_before = content_of(*old->second);
  } else if (const auto removed = removed_content_.find(path); removed != removed_content_.end()) {
    entry->content_before = removed->second;
    removed_content_.erase(removed);
  }
  entries_.insert_or_assign(path, std::move(entry));
  has_changed_ = true;
}

/// The target file of a link, if it is below the folder of the source. Otherwise logs the link
/// once.
std::optional<FileIdentity> CatalogEntries::look_at_link(const std::string& path,
                                                         const StoreFolder& folder) {
  std::error_code error;
  const fs::path target = fs::canonical(path, error);
  // The identity of the current target is compared with the file that is opened later.
  struct stat status {};
  const bool is_file = !error && ::lstat(target.c_str(), &status) == 0 && S_ISREG(status.st_mode);
  if (is_file && target.native().starts_with(folder.root + '/')) {
    refused_.erase(path);
    if (const Result<FileIdentity> known = file_identity(target)) return *known;
    return std::nullopt;
  }
  if (refused_.insert(path).second) {
    log_(fmt::format("{}: not served: it is a link out of the folder", path));
  }
  return std::nullopt;
}

void CatalogEntries::renew(const std::string& path) {
  const auto old = entries_.find(path);
  if (old == entries_.end()) return;
  const CatalogEntry& before = *old->second;
  auto entry = std::make_shared<CatalogEntry>();
  static_cast<VolumeIdentity&>(*entry) = before;
  entry->id = ++last_id_;
  entry->name = before.name;
  entry->path = before.path;
  entry->root = before.root;
  entry->content_before = content_of(before);
  entry->must_be_identity = before.must_be_identity;
  entry->identity = before.identity;
  entry->thumbnail = before.thumbnail;
  entry->is_one_of_many = before.is_one_of_many;
  old->second = std::move(entry);
  has_changed_ = true;
}

void CatalogEntries::forget(const std::string& path) {
  if (const auto entry = entries_.find(path); entry != entries_.end()) forget(entry);
}

void CatalogEntries::forget(ByPath::iterator entry) {
  log_(fmt::format("{} {} was removed: {}", word_of(kind_), entry->second->name, entry->first));
  // If another file appears under this name, it is logged.
  if (removed_content_.size() >= kMaxStores) removed_content_.clear();
  if (std::string content = content_of(*entry->second); !content.empty()) {
    removed_content_.insert_or_assign(entry->first, std::move(content));
  }
  entries_.erase(entry);
  has_changed_ = true;
}

void CatalogEntries::forget_all_but(const FoundStores& found) {
  forget_range(entries_.begin(), entries_.end(), found);
}

void CatalogEntries::forget_below_but(const std::string& path, const FoundStores& found) {
  forget_range(entries_.lower_bound(path + '/'), entries_.lower_bound(end_of(path)), found);
}

void CatalogEntries::forget_range(ByPath::iterator begin, ByPath::iterator end,
                                  const FoundStores& found) {
  for (auto entry = begin; entry != end;) {
    const auto next = std::next(entry);
    if (!found.contains(entry->first)) forget(entry);
    entry = next;
  }
}

void CatalogEntries::find_below(const std::string& path, const StoreFolder& folder,
                                FoundStores& found) const {
  const auto end = entries_.lower_bound(end_of(path));
  for (auto entry = entries_.lower_bound(path + '/'); entry != end; ++entry) {
    found.emplace(entry->first, &folder);
  }
}

std::shared_ptr<const CatalogSnapshot> CatalogEntries::changed_snapshot() {
  if (!std::exchange(has_changed_, false)) return nullptr;
  auto after = std::make_shared<CatalogSnapshot>();
  for (const auto& [path, entry] : entries_) {
    const auto [item, is_new] = after->emplace(entry->name, entry);
    if (is_new || !refused_.insert(path).second) continue;
    log_(fmt::format("{}: not served: {} has the same name, {}: rename it", path,
                     item->second->path.string(), entry->name));
  }
  return after;
}

}  // namespace isosplat::server
