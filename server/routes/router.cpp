#include "server/routes/router.h"

#include <utility>

namespace isosplat::server {

Router::Router(const Catalog& catalog, StorePool& stores, RouterLimits limits)
    : catalog_(catalog), stores_(stores), limits_(limits) {}

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

void Router::count_volumes() {
  const auto access = current().access;
  const auto catalog = catalog_.snapshot();
  const uint64_t news = stores_.news();
  if (access == counted_access_ && catalog == counted_catalog_ && news == counted_news_) return;
  VolumeCounts counts;
  const auto is_broken = [](const CatalogEntry& entry) {
    return entry.summary.state() == StoreState::broken;
  };
  const auto open_to_all = views_.make(catalog, AccessRules::grant(access, {}, 0));
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
  counted_access_ = access;
  counted_catalog_ = catalog;
  counted_news_ = news;
  const std::lock_guard lock(mutex_);
  counts_ = counts;
}

}  // namespace isosplat::server
