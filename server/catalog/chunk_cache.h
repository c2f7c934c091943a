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

/// The most recently sent chunks, with verified checksums. Many clients request the same chunks; a
/// cached chunk is sent without reading, verifying or copying it again. Thread-safe.
class ChunkCache {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  using Store = std::shared_ptr<const StoreFile>;

  /// `capacity`: the maximum bytes of chunks to keep. The least recently used chunks are dropped.
  explicit ChunkCache(uint64_t capacity) : capacity_(capacity) {}

  /// The chunk of this store at this offset of its file; null if it is not cached. The caller must
  /// check whether the file was changed since (StoreFile::check_unchanged).
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
    std::weak_ptr<const StoreFile> store;  ///< another store may have the same address by now
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
