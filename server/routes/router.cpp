#include "server/routes/router.h"

#include <utility>

namespace isosplat::server {

Router::Router(const Catalog& catalog, StorePool& stores, ScenePool& scenes, RouterLimits limits)
    : catalog_(catalog), stores_(stores), scenes_(scenes), limits_(limits) {}

void Router::set_page(std::shared_ptr<const PageAssets> page) {
  const std::lock_guard lock(mutex_);
  page_ = std::move(page);
}

void Router::set_access(std::shared_ptr<const AccessRules> access) {
  if (access && access->is_open()) access.reset();
  const std::lock_guard lock(mutex_);
  access_ = std::move(access);
}

Router::Current Router::current() const {
  const std::lock_guard lock(mutex_);
  return {page_, access_, counts_};
}

void Router::count_files() {
  count(ServedKind::volume, stores_.news(), views_, counted_volumes_);
  count(ServedKind::scene, scenes_.news(), scene_views_, counted_scenes_);
  const std::lock_guard lock(mutex_);
  counts_ = {counted_volumes_.counts, counted_scenes_.counts};
}

void Router::count(ServedKind kind, uint64_t news, VolumeViews& views, Counted& counted) {
  auto access = current().access;
  auto catalog = catalog_.snapshot(kind);
  if (access == counted.access && catalog == counted.catalog && news == counted.news) return;
  VolumeCounts counts;
  const auto is_broken = [](const CatalogEntry& entry) {
    return entry.summary.state() == StoreState::broken;
  };
  const auto open_to_all = views.make(catalog, AccessRules::grant(access, {}, 0));
  counts.open_to_all = open_to_all->entries.size();
  for (const CatalogEntry* entry : open_to_all->entries) {
    if (is_broken(*entry)) ++counts.open_to_all_broken;
  }
  for (const auto& [name, entry] : *catalog) {
    const StoreState state = entry->summary.state();
    ++(state == StoreState::served   ? counts.served
       : state == StoreState::broken ? counts.broken
                                     : counts.unread);
  }
  counted = {std::move(access), std::move(catalog), news, counts};
}

}  // namespace isosplat::server
