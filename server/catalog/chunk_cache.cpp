#include "server/catalog/chunk_cache.h"

#include <iterator>
#include <utility>

namespace isosplat::server {

size_t ChunkCache::Hash::operator()(const Key& key) const {
  constexpr uint64_t kOddNumber = 0x9e3779b97f4a7c15;
  return (reinterpret_cast<uintptr_t>(key.store) ^ key.offset * kOddNumber) * kOddNumber >> 17;
}

ChunkCache::Bytes ChunkCache::find(const Store& store, uint64_t offset) {
  const std::lock_guard lock(mutex_);
  const auto found = positions_.find(Key{store.get(), offset});
  if (found == positions_.end()) return nullptr;
  const Position position = found->second;
  const bool is_same = !position->store.owner_before(store) && !store.owner_before(position->store);
  if (!is_same) return nullptr;
  by_use_.splice(by_use_.begin(), by_use_, position);
  return position->bytes;
}

void ChunkCache::add(const Store& store, uint64_t offset, Bytes bytes) {
  const uint64_t size = bytes->size();
  if (size > capacity_ / 8) return;
  const Key key{store.get(), offset};
  std::list<Kept> dropped;  // destroyed after the lock is released: freeing may take long
  std::list<Kept> added;    // before the lock: the allocation may fail
  added.push_front({key, store, std::move(bytes)});
  const std::lock_guard lock(mutex_);
  if (const auto found = positions_.find(key); found != positions_.end()) {
    drop(found->second, dropped);
  }
  positions_.emplace(key, added.begin());
  by_use_.splice(by_use_.begin(), added);
  bytes_ += size;
  while (bytes_ > capacity_) drop(std::prev(by_use_.end()), dropped);
}

void ChunkCache::drop(Position position, std::list<Kept>& dropped) {
  bytes_ -= position->bytes->size();
  positions_.erase(position->key);
  dropped.splice(dropped.end(), by_use_, position);
}

uint64_t ChunkCache::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

}  // namespace isosplat::server
