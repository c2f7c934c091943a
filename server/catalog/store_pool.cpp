#include "server/catalog/store_pool.h"

#include <utility>

#include "server/catalog/keep_summary.h"
#include "server/catalog/volume_json.h"

namespace isosplat::server {
namespace {

/// Replaces the path by the file's name: clients may read the message, and must not learn folders.
Error with_file_name(Error error, const std::filesystem::path& path) {
  const std::string full = path.string(), name = path.filename().string();
  size_t at = 0;
  while (full != name && (at = error.message.find(full, at)) != std::string::npos) {
    error.message.replace(at, full.size(), name);
    at += name.size();
  }
  return error;
}

}  // namespace

Result<std::shared_ptr<const StoreFile>> StorePool::open_file(const CatalogEntry& entry) {
  for (bool is_first = true;; is_first = false) {
    auto opened = StoreFile::open(entry.path, limits_.directory_bytes);
    if (opened && entry.must_be_identity && !((*opened)->identity() == *entry.identity)) {
      return fail(Status::io_error,
                  entry.path.string() + ": was replaced while it was opened: try again");
    }
    if (opened) return std::shared_ptr<const StoreFile>(std::move(*opened));
    if (opened.error().status != Status::io_error || has_descriptors()) {
      return tl::unexpected(std::move(opened.error()));
    }
    close_half();
    if (is_first) continue;
    return fail(Status::out_of_memory,
                entry.path.string() + ": the server has used up its file descriptors: try again");
  }
}

std::shared_ptr<const StoreSummary> StorePool::remember(
    const CatalogEntry& entry, const Result<std::shared_ptr<const StoreFile>>& store) {
  auto summary = std::make_shared<StoreSummary>();
  if (store) {
    *summary = summary_of(entry.name, **store);
  } else {
    *summary = summary_of(entry.name, with_file_name(store.error(), entry.path));
  }
  if (keep_summary(entry, summary, store ? nullptr : &store.error(), log_)) ++news_;
  return summary;
}

std::shared_ptr<const StoreFile> StorePool::find(uint64_t id) {
  const std::lock_guard lock(mutex_);
  const auto found = positions_.find(id);
  if (found == positions_.end()) return nullptr;
  by_use_.splice(by_use_.begin(), by_use_, found->second);
  return found->second->store;
}

Result<std::shared_ptr<const StoreFile>> StorePool::open(const CatalogEntry& entry,
                                                         NoWait* no_wait) {
  if (auto store = find(entry.id)) return store;
  if (const auto summary = entry.summary.get(); summary && summary->error) {
    return tl::unexpected(*summary->error);
  }
  if (no_wait) {
    no_wait->needs_disk = true;
    return fail(Status::io_error, "the store is not open yet");
  }
  auto store = open_file(entry);
  if (const auto summary = remember(entry, store); !store) return tl::unexpected(*summary->error);
  ++opened_;
  std::list<Open> closed;  // destroyed after the lock is released: closing a file may take long
  const std::lock_guard lock(mutex_);
  const auto [position, is_new] = positions_.try_emplace(entry.id);
  if (!is_new) return position->second->store;  // another thread was faster
  by_use_.push_front({entry.id, entry.name, *store});
  position->second = by_use_.begin();
  while (by_use_.size() > limits_.stores) close(std::prev(by_use_.end()), closed);
  return store;
}

std::shared_ptr<const StoreSummary> StorePool::summary(const CatalogEntry& entry, NoWait* no_wait) {
  if (auto summary = entry.summary.get()) return summary;
  if (no_wait) {
    no_wait->needs_disk = true;
    return nullptr;
  }
  return remember(entry, open_file(entry));
}

void StorePool::close(Position position, std::list<Open>& closed) {
  positions_.erase(position->id);
  closed.splice(closed.end(), by_use_, position);
}

void StorePool::close_half() {
  std::list<Open> closed;
  const std::lock_guard lock(mutex_);
  for (size_t left = by_use_.size() / 2; by_use_.size() > left;) {
    close(std::prev(by_use_.end()), closed);
  }
}

void StorePool::trim(const CatalogSnapshot& snapshot) {
  std::list<Open> closed;
  const std::lock_guard lock(mutex_);
  uint64_t bytes = 0;
  for (Position position = by_use_.begin(); position != by_use_.end();) {
    const Position next = std::next(position);
    const auto entry = snapshot.find(position->name);
    const bool is_gone = entry == snapshot.end() || entry->second->id != position->id;
    const uint64_t after = bytes + position->store->directory_bytes();
    if (is_gone || after > limits_.all_directory_bytes) {
      close(position, closed);
    } else {
      bytes = after;
    }
    position = next;
  }
}

size_t StorePool::size() const {
  const std::lock_guard lock(mutex_);
  return by_use_.size();
}

}  // namespace isosplat::server
