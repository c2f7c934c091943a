#include "server/catalog/scene_pool.h"

#include <utility>

#include "server/catalog/keep_summary.h"
#include "server/catalog/thumbnail.h"

namespace isosplat::server {
namespace {

namespace fs = std::filesystem;

/// Memory of a scene: its header, parsed and encoded, and the paths of its stores.
uint64_t memory_of(const ServedScene& scene) {
  constexpr uint64_t kPerStore = 512;
  const BundleHeader& header = scene.bytes.header();
  return 2 * header.header_bytes + kPerStore * header.stores.size();
}

}  // namespace

Error without_folder(Error error, const fs::path& folder) {
  const std::string prefix = folder.string() + '/';
  if (prefix.size() == 1) return error;
  for (size_t at = 0; (at = error.message.find(prefix, at)) != std::string::npos;) {
    error.message.erase(at, prefix.size());
  }
  return error;
}

Result<std::shared_ptr<const ServedScene>> ScenePool::open_file(const CatalogEntry& entry) const {
  const auto no_descriptors = [&] {
    return fail(Status::out_of_memory,
                entry.path.string() + ": the server has used up its file descriptors: try again");
  };
  const auto opened = SceneFile::open(entry.path);
  if (!opened) {
    if (!has_descriptors()) return no_descriptors();
    return tl::unexpected(opened.error());
  }
  std::optional<fs::path> within;
  if (links_ == OutsideLinks::refused) within = entry.root;
  auto bytes = BundleBytes::plan(*opened, within);
  if (!bytes) {
    if (!has_descriptors()) return no_descriptors();
    return tl::unexpected(bytes.error());
  }
  if (entry.must_be_identity && !(bytes->scene_identity() == *entry.identity)) {
    return fail(Status::io_error,
                entry.path.string() + ": was replaced while it was opened: try again");
  }
  SceneFacts facts = facts_of(opened->scene(), bytes->content(), bytes->bytes());
  facts.has_thumbnail = read_thumbnail(entry.path, facts.content).has_value();
  return std::make_shared<const ServedScene>(
      ServedScene{std::move(*bytes), std::move(facts), entry.path});
}

std::shared_ptr<const StoreSummary> ScenePool::remember(
    const CatalogEntry& entry, const Result<std::shared_ptr<const ServedScene>>& scene) {
  auto summary = std::make_shared<StoreSummary>();
  if (scene) {
    *summary = scene_summary(entry.name, (*scene)->facts);
  } else {
    *summary = scene_summary(entry.name, without_folder(scene.error(), entry.path.parent_path()));
  }
  if (keep_summary(entry, summary, scene ? nullptr : &scene.error(), log_)) ++news_;
  return summary;
}

std::shared_ptr<const ServedScene> ScenePool::find(uint64_t id) {
  const std::lock_guard lock(mutex_);
  const auto found = positions_.find(id);
  if (found == positions_.end()) return nullptr;
  by_use_.splice(by_use_.begin(), by_use_, found->second);
  return found->second->scene;
}

void ScenePool::keep(const CatalogEntry& entry, const std::shared_ptr<const ServedScene>& scene) {
  const std::lock_guard lock(mutex_);
  const auto [position, is_new] = positions_.try_emplace(entry.id);
  if (!is_new) return;  // another thread was faster
  by_use_.push_front({entry.id, entry.name, entry.path, scene});
  position->second = by_use_.begin();
  bytes_ += memory_of(*scene);
  while (by_use_.size() > limits_.scenes || (bytes_ > limits_.bytes && by_use_.size() > 1)) {
    close(std::prev(by_use_.end()));
  }
  // The stores may have changed since this entry was examined and its scene was closed.
  const auto summary = entry.summary.get();
  if (summary && summary->content != scene->facts.content) stale_.push_back(entry.path);
}

void ScenePool::close(Position position) {
  bytes_ -= memory_of(*position->scene);
  positions_.erase(position->id);
  by_use_.erase(position);
}

Result<std::shared_ptr<const ServedScene>> ScenePool::open(const CatalogEntry& entry,
                                                           NoWait* no_wait) {
  if (auto scene = find(entry.id)) return scene;
  if (const auto summary = entry.summary.get(); summary && summary->error) {
    return tl::unexpected(*summary->error);
  }
  if (no_wait) {
    no_wait->needs_disk = true;
    return fail(Status::io_error, "the scene is not open yet");
  }
  auto scene = open_file(entry);
  if (const auto summary = remember(entry, scene); !scene) return tl::unexpected(*summary->error);
  keep(entry, *scene);
  return scene;
}

std::shared_ptr<const StoreSummary> ScenePool::summary(const CatalogEntry& entry, NoWait* no_wait) {
  if (auto summary = entry.summary.get()) return summary;
  if (no_wait) {
    no_wait->needs_disk = true;
    return nullptr;
  }
  const auto scene = open_file(entry);
  auto summary = remember(entry, scene);
  if (scene) keep(entry, *scene);
  return summary;
}

/// Whether a scene that could not be served can be served now, or has another error.
bool ScenePool::has_other_error(const CatalogEntry& entry) const {
  const auto known = entry.summary.get();
  if (!known || !known->error) return false;
  const auto scene = open_file(entry);
  return scene ||
         without_folder(scene.error(), entry.path.parent_path()).message != known->error->message;
}

std::vector<fs::path> ScenePool::examine(const CatalogSnapshot& snapshot) {
  std::vector<Open> open;
  std::vector<fs::path> changed;
  {
    const std::lock_guard lock(mutex_);
    for (Position position = by_use_.begin(); position != by_use_.end();) {
      const Position next = std::next(position);
      const auto entry = snapshot.find(position->name);
      const bool is_gone = entry == snapshot.end() || entry->second->id != position->id;
      if (is_gone) close(position);
      position = next;
    }
    changed.swap(stale_);
    if (Clock::now() - last_examination_ < 20 * examination_time_) return changed;
    open.assign(by_use_.begin(), by_use_.end());
  }
  const Clock::time_point begin = Clock::now();
  for (const Open& each : open) {
    const BundleBytes& bytes = each.scene->bytes;
    if (bytes.has_separate_stores() && !bytes.is_current()) changed.push_back(each.path);
  }
  for (const auto& [name, entry] : snapshot) {
    // The catalog notices changes of bundles, which are single files.
    const bool is_bundle = entry->path.native().ends_with(kBundleExtension);
    if (!is_bundle && has_other_error(*entry)) changed.push_back(entry->path);
  }
  last_examination_ = Clock::now();
  examination_time_ = last_examination_ - begin;
  return changed;
}

size_t ScenePool::size() const {
  const std::lock_guard lock(mutex_);
  return by_use_.size();
}

}  // namespace isosplat::server
