#include "native/scene/layer_surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

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

Error with_layer(const Scene& scene, size_t layer, Error error) {
  error.message = name_of(scene, layer) + ": " + error.message;
  return error;
}

std::string no_surfaces(const Scene& scene, size_t layer) {
  return name_of(scene, layer) +
         " has no surfaces, and its store suggests no isovalue: add a surface to the layer";
}

Result<OpenedLayer> open_layer(const SceneFile& scene, size_t index, size_t step) {
  const SceneLayer& layer = scene.scene().layers[index];
  const auto failed = [&](Error error) {
    return tl::unexpected(with_layer(scene.scene(), index, std::move(error)));
  };
  auto store = scene.open_store(store_at(layer, step));
  if (!store) return failed(store.error());
  OpenedLayer opened{std::move(*store), {}};
  opened.grid = opened.store->info().grid;
  if (layer.transform) {
    const auto placed = transformed(opened.grid, *layer.transform);
    if (!placed) return failed(placed.error());
    opened.grid = *placed;
  }
  return opened;
}

Result<void> check_step(const Scene& scene, size_t step) {
  const size_t steps = scene.time ? scene.time->values.size() : 1;
  if (step < steps) return {};
  return fail(
      Status::not_found,
      fmt::format("expected a time step from 0 to {}, found {}: choose another step with --step",
                  steps - 1, step));
}

}  // namespace isosplat
