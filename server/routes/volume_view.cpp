#include "server/routes/volume_view.h"

#include <algorithm>

namespace isosplat::server {

std::shared_ptr<const VolumeView> VolumeViews::find(const Catalog& catalog, const Grant& grant) {
  const std::string key = grant.key();
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find_if(
      kept_, [&](const Kept& kept) { return kept.view->catalog == catalog && kept.key == key; });
  if (found == kept_.end()) return nullptr;
  kept_.splice(kept_.begin(), kept_, found);
  return found->view;
}

std::shared_ptr<const VolumeView> VolumeViews::make(const Catalog& catalog, const Grant& grant) {
  if (auto view = find(catalog, grant)) return view;
  auto made = std::make_shared<VolumeView>();
  made->catalog = catalog;
  for (const auto& [name, entry] : *catalog) {
    if (!grant.may_read(name, *entry)) continue;
    made->entries.push_back(entry.get());
    if (entry->identity) made->bytes += entry->identity->bytes;
  }
  const std::lock_guard lock(mutex_);
  // Views of older snapshots are not needed any more.
  std::erase_if(kept_, [&](const Kept& kept) { return kept.view->catalog != catalog; });
  kept_.push_front({grant.key(), made});
  if (kept_.size() > kMost) kept_.pop_back();
  return made;
}

}  // namespace isosplat::server
