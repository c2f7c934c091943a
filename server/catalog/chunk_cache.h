#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "shared/system/store_file/store_file.h"

namespace isosplat::server {

/// The chunks that were sent last, after their checksums were verified. Many clients ask for the
/// same ones, which are then sent as they are: not read, not verified and not copied again.
/// Thread-safe.
class ChunkCache {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  using Store = std::shared_ptr<const StoreFile>;

  /// `capacity`: the most bytes of chunks to keep; those that were used least recently are dropped.
  explicit ChunkCache(uint64_t capacity) : capacity_(capacity) {}

  /// The chunk of this store that begins at this offset of its file; null if it is not kept. The
  /// file may have been changed since (StoreFile::check_unchanged).
  Bytes find(const Store& store, uint64_t offset);

  /// Keeps a chunk, unless it is larger than an eighth of the capacity.
  void add(const Store& store, uint64_t offset, Bytes bytes);

  /// Bytes of the chunks that are kept.
  uint64_t bytes() const;

 private:
  struct Key {
    const StoreFile* store;
    uint64_t offset;
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct Hash {
    size_t operator()(const Key& key) const;
  };
  struct Kept {
    Key key;
    std::weak_ptr<const StoreFile> store;  ///< another one may be at the same address by now
    Bytes bytes;
  };
  using Position = std::list<Kept>::iterator;

  /// Moves it to `dropped`. The caller must hold mutex_.
  void drop(Position position, std::list<Kept>& dropped);

  const uint64_t capacity_;
  mutable std::mutex mutex_;
  uint64_t bytes_ = 0;                                 // guarded by mutex_
  std::list<Kept> by_use_;                             // guarded by mutex_; latest first
  std::unordered_map<Key, Position, Hash> positions_;  // guarded by mutex_
};

}  // namespace isosplat::server
