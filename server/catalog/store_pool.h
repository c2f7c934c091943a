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

/// Opens stores when they are asked for, and keeps those open that were used last. Thread-safe.
class StorePool {
 public:
  using Log = std::function<void(std::string_view)>;

  struct Limits {
    size_t stores = 256;                                 ///< open at a time, besides those in use
    uint64_t directory_bytes = uint64_t{64} << 20;       ///< directory pages in memory, per store
    uint64_t all_directory_bytes = uint64_t{512} << 20;  ///< those of all stores, after trim()
  };
  StorePool(Limits limits, Log log) : limits_(limits), log_(std::move(log)) {}

  /// The store of an entry. Whoever holds it can read it to its end, also if its file is replaced
  /// or removed. With `no_wait`, fails and says so in it if the store is not open. Errors: those of
  /// StoreFile::open, with the file's name but not its folder; out_of_memory if the system has no
  /// file descriptors left, in which case others were closed.
  Result<std::shared_ptr<const StoreFile>> open(const CatalogEntry& entry,
                                                NoWait* no_wait = nullptr);

  /// What the header of an entry's store says; read once, without keeping the store open. Null if
  /// that must wait, in which case `no_wait` says so. Never null without `no_wait`.
  std::shared_ptr<const StoreSummary> summary(const CatalogEntry& entry, NoWait* no_wait = nullptr);

  /// Closes stores that are not in the snapshot (any more), and the least recently used ones above
  /// the limit of directory pages. Call it regularly.
  void trim(const CatalogSnapshot& snapshot);

  size_t size() const;                         ///< stores that are open now
  uint64_t opened() const { return opened_; }  ///< how often a store was opened for a request

  /// A number that changes when something new is known of a store.
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
