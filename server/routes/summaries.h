#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "server/routes/route_call.h"

namespace isosplat::server {

/// The progress of a handler that iterates over all volumes, in one or more turns
/// (RouteCall::turn). The volumes before `next` are done.
struct CatalogProgress : WorkTurn::Progress {
  explicit CatalogProgress(std::shared_ptr<const CatalogSnapshot> snapshot)
      : catalog(std::move(snapshot)), next(catalog->begin()) {}

  const std::shared_ptr<const CatalogSnapshot> catalog;  ///< the same in all turns
  CatalogSnapshot::const_iterator next;
};

/// The handler's progress, stored in the call's turn, or in `own` if there is no turn.
template <class Progress>
Progress& progress_of(const RouteCall& call, std::unique_ptr<WorkTurn::Progress>& own) {
  std::unique_ptr<WorkTurn::Progress>& progress = call.turn ? call.turn->progress : own;
  if (!progress) progress = std::make_unique<Progress>(call.volumes.catalog);
  return static_cast<Progress&>(*progress);
}

/// The summaries of stores and scenes, within the limit of a turn: at most kHeadersPerTurn headers
/// of stores that have not been read yet, or one scene, which may have many stores.
class Summaries {
 public:
  explicit Summaries(const RouteCall& call) : call_(call) {}

  /// Null if it cannot be read now: either it must wait, or it needs another turn, and `turn` then
  /// says so.
  std::shared_ptr<const StoreSummary> of(const CatalogEntry& entry);

 private:
  const RouteCall& call_;
  uint32_t read_ = 0;
  uint64_t last_id_ = 0;
  std::shared_ptr<const StoreSummary>
      last_;  // an entry does not store a summary with a temporary error
};

}  // namespace isosplat::server
