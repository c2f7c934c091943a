#include "native/scene/layer_surfaces.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace isosplat {

std::optional<double> suggested_isovalue(const StoreInfo& info) {
  const auto metadata = nlohmann::json::parse(info.metadata, nullptr, false);
  if (!metadata.is_object()) return std::nullopt;
  const auto found = metadata.find("suggested_isovalues");
  if (found == metadata.end() || !found->is_array() || found->empty() ||
      !found->front().is_number()) {
    return std::nullopt;
  }
  return found->front().get<double>();
}

std::vector<SceneSurface> surfaces_of(const SceneLayer& layer, const StoreInfo& info,
                                      size_t number) {
  std::vector<SceneSurface> surfaces = layer.surfaces;
  if (surfaces.empty()) {
    if (const auto isovalue = suggested_isovalue(info)) {
      surfaces.emplace_back().isovalue = *isovalue;
    }
  }
  for (size_t i = 0; i < surfaces.size(); ++i) {
    if (surfaces[i].colour) continue;
    const Vec3f colour = kSurfaceColours[(number + i) % kSurfaceColours.size()];
    surfaces[i].colour = {colour.x, colour.y, colour.z};
  }
  return surfaces;
}

std::string name_of(const Scene& scene, size_t layer) {
  const std::string& name = scene.layers[layer].name;
  return name.empty() ? fmt::format("layer {}", layer) : fmt::format("layer {} ({})", layer, name);
}

}  // namespace isosplat
