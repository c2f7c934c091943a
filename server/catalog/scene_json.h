#pragma once

#include <string>
#include <string_view>

#include "server/catalog/store_summary.h"
#include "shared/core/base/status.h"
#include "shared/core/scene/scene.h"

namespace isosplat::server {

/// The properties of a scene that lists show.
struct SceneFacts {
  std::string content;  ///< hexadecimal content id of its bundle
  uint64_t bytes = 0;   ///< of its bundle
  std::string title;    ///< may be empty
  size_t layers = 0;
  size_t steps = 0;  ///< 0: it does not change with time
  bool has_thumbnail = false;
};

SceneFacts facts_of(const Scene& scene, std::string content, uint64_t bytes);

/// The summary of a scene that can be served, and of one that cannot.
StoreSummary scene_summary(const std::string& name, const SceneFacts& facts);
StoreSummary scene_summary(const std::string& name, Error error);

/// A scene in the catalog of a static site. It equals that in /v1/scenes, but has `file` in place
/// of `url`, and `thumbnail` is the file of its picture; empty: it has none.
std::string published_scene_json(std::string_view name, std::string_view file,
                                 const SceneFacts& facts, std::string_view thumbnail);

/// The body of /v1/scenes/{name}.
std::string scene_json(std::string_view name, const SceneFacts& facts);

}  // namespace isosplat::server
