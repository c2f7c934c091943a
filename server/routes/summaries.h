#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "server/routes/route_call.h"

namespace isosplat::server {

/// How far a handler has come that goes through all volumes, in one or more turns
/// (RouteCall::turn): those before `next` are done.
struct CatalogProgress : WorkTurn::Progress {
  explicit CatalogProgress(std::shared_ptr<const CatalogSnapshot> its_catalog)
      : catalog(std::move(its_catalog)), next(catalog->begin()) {}

  const std::shared_ptr<const CatalogSnapshot> catalog;  ///< the same in all turns
  CatalogSnapshot::const_iterator next;
};

/// The handler's progress, kept in the call's turn, or in `own` if it has none.
template <class Progress>
Progress& progress_of(const RouteCall& call, std::unique_ptr<WorkTurn::Progress>& own) {
  std::unique_ptr<WorkTurn::Progress>& progress = call.turn ? call.turn->progress : own;
  if (!progress) progress = std::make_unique<Progress>(call.catalog);
  return static_cast<Progress&>(*progress);
}

/// The summaries of stores, as far as this turn may read them: at most kHeadersPerTurn headers that
/// nobody has read yet.
class Summaries {
 public:
  explicit Summaries(const RouteCall& call) : call_(call) {}

  /// Null if it cannot be read now: it must wait, or needs another turn, which `turn` then says.
  std::shared_ptr<const StoreSummary> of(const CatalogEntry& entry);

 private:
  const RouteCall& call_;
  uint32_t read_ = 0;
  uint64_t last_id_ = 0;
  std::shared_ptr<const StoreSummary> last_;  // one with an error that may pass is not in the entry
};

}  // namespace isosplat::server
