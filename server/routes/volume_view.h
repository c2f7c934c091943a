#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/access/access_rules.h"
#include "server/catalog/catalog.h"

namespace isosplat::server {

/// The volumes of a snapshot that one client may read, by name.
struct VolumeView {
  std::shared_ptr<const CatalogSnapshot> catalog;
  std::vector<const CatalogEntry*> entries;  ///< of `catalog`
  uint64_t bytes = 0;                        ///< of their files
};

/// Caches views, so that the cost of a request does not depend on the client or on the numbers of
/// stores and patterns. Thread-safe.
class VolumeViews {
 public:
  using Catalog = std::shared_ptr<const CatalogSnapshot>;

  /// The cached view of a client; null if there is none.
  std::shared_ptr<const VolumeView> find(const Catalog& catalog, const Grant& grant);

  /// The same; computes it if needed, in a time proportional to stores and patterns.
  std::shared_ptr<const VolumeView> make(const Catalog& catalog, const Grant& grant);

 private:
  static constexpr size_t kMost = 16;

  struct Kept {
    std::string key;  ///< Grant::key()
    std::shared_ptr<const VolumeView> view;
  };

  std::mutex mutex_;
  std::list<Kept> kept_;  // guarded by mutex_; most recently used first
};

}  // namespace isosplat::server
