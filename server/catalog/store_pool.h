#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string_view>
#include <unordered_map>

#include "server/catalog/catalog.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::server {

/// Opens stores when they are requested, and keeps the most recently used ones open. Thread-safe.
class StorePool {
 public:
  using Log = std::function<void(std::string_view)>;

  struct Limits {
    size_t stores = 256;  ///< maximum number of open stores, in addition to those in use
    uint64_t directory_bytes = uint64_t{64} << 20;       ///< directory pages in memory, per store
    uint64_t all_directory_bytes = uint64_t{512} << 20;  ///< those of all stores, after trim()
  };
  StorePool(Limits limits, Log log) : limits_(limits), log_(std::move(log)) {}

  /// Returns the store of an entry, opened. Its holder can read it to its end, even if its file is
  /// replaced or removed. With `no_wait`, fails if the store is not open, and sets
  /// no_wait->needs_disk. Errors: those of StoreFile::open, with the file's name but not its
  /// folder; out_of_memory if the system has no file descriptors left, in which case other stores
  /// were closed.
  Result<std::shared_ptr<const StoreFile>> open(const CatalogEntry& entry,
                                                NoWait* no_wait = nullptr);

  /// Returns a summary of the header of an entry's store. The header is read once, and the store
  /// does not stay open. Null if this must wait for the disk and `no_wait` is given, which is then
  /// set.
  std::shared_ptr<const StoreSummary> summary(const CatalogEntry& entry, NoWait* no_wait = nullptr);

  /// Closes stores that are no longer in the snapshot, and the least recently used ones above the
  /// limit of directory pages. Call it regularly.
  void trim(const CatalogSnapshot& snapshot);

  size_t size() const;                         ///< stores that are open now
  uint64_t opened() const { return opened_; }  ///< how often a store was opened for a request

  /// A number that changes with each new summary of a store.
  uint64_t news() const { return news_; }

 private:
  struct Open {
    uint64_t id = 0;  ///< of the entry
    std::string name;
    std::shared_ptr<const StoreFile> store;
  };
  using Position = std::list<Open>::iterator;

  Result<std::shared_ptr<const StoreFile>> open_file(const CatalogEntry& entry);
  std::shared_ptr<const StoreFile> find(uint64_t id);
  void close_half();
  void close(Position position, std::list<Open>& closed);
  std::shared_ptr<const StoreSummary> remember(
      const CatalogEntry& entry, const Result<std::shared_ptr<const StoreFile>>& store);

  const Limits limits_;
  const Log log_;
  std::atomic<uint64_t> opened_{0};
  std::atomic<uint64_t> news_{0};
  mutable std::mutex mutex_;
  std::list<Open> by_use_;                            // guarded by mutex_; the last used first
  std::unordered_map<uint64_t, Position> positions_;  // guarded by mutex_; by id
};

}  // namespace isosplat::server
