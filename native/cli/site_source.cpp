#include "native/cli/site_source.h"

#include <fmt/format.h>

#include <utility>

namespace isosplat::cli {

namespace fs = std::filesystem;

Result<SiteSource> SiteSource::open(server::ServedKind kind, const fs::path& path) {
  SiteSource source;
  source.path_ = path;
  if (kind == server::ServedKind::volume) {
    auto store = StoreFile::open(path);
    if (!store) return tl::unexpected(store.error());
    source.content_ = (*store)->content();
    source.store_ = std::move(*store);
    return source;
  }
  const auto scene = SceneFile::open(path);
  if (!scene) return tl::unexpected(scene.error());
  auto bundle = BundleBytes::plan(*scene);
  if (!bundle) {
    Error error = bundle.error();
    if (!error.message.starts_with(path.string())) {
      error.message = path.string() + ": " + error.message;
    }
    return tl::unexpected(std::move(error));
  }
  source.content_ = bundle->content();
  source.facts_ = server::facts_of(scene->scene(), bundle->content(), bundle->bytes());
  if (bundle->has_separate_stores()) {
    for (const std::string& store : store_paths(scene->scene())) {
      source.stores_.insert((path.parent_path() / store).lexically_normal());
    }
  }
  source.scene_ = std::make_shared<const BundleBytes>(std::move(*bundle));
  return source;
}

Result<void> SiteSource::read(uint64_t offset, std::span<std::byte> out) const {
  return scene_ ? scene_->read(offset, out) : store_->read(offset, out);
}

Result<void> SiteSource::check_unchanged() const {
  if (store_) return store_->check_unchanged();
  if (scene_->is_current()) return {};
  return fail(Status::io_error, fmt::format("{}: its files were changed while they were copied: "
                                            "publish it again",
                                            path_.string()));
}

}  // namespace isosplat::cli
