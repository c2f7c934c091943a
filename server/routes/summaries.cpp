#include "server/routes/summaries.h"

#include "server/catalog/scene_pool.h"
#include "server/catalog/store_pool.h"

namespace isosplat::server {

std::shared_ptr<const StoreSummary> Summaries::of(const CatalogEntry& entry) {
  if (last_ && last_id_ == entry.id) return last_;
  last_id_ = entry.id;
  last_ = entry.summary.get();
  if (last_) return last_;
  if (call_.turn && read_ >= kHeadersPerTurn) {
    call_.turn->is_unfinished = true;
    return nullptr;
  }
  if (entry.kind == ServedKind::scene) {
    read_ += kHeadersPerTurn;
    return last_ = call_.scene_pool.summary(entry, call_.no_wait);
  }
  ++read_;
  return last_ = call_.stores.summary(entry, call_.no_wait);
}

}  // namespace isosplat::server
