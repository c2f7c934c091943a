#include "native/cli/info_scene.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/terminal.h"
#include "shared/system/scene_file/scene_file.h"

namespace isosplat::cli {
namespace {

using Json = nlohmann::ordered_json;

void print_line(std::string_view label, std::string_view text) {
  fmt::print("{:<14}{}\n", printable(label), printable(text));
}

/// The store of a layer at the step that the scene shows first, or the error.
struct LayerStore {
  std::shared_ptr<StoreFile> store;
  std::string error;
};

LayerStore open_layer(const SceneFile& file, const SceneLayer& layer) {
  const auto opened = file.open_store(store_at(layer, first_step(file.scene())));
  if (!opened) return {nullptr, opened.error().message};
  return {*opened, ""};
}

Json layer_json(const SceneFile& file, const SceneLayer& layer) {
  Json surfaces = Json::array();
  for (const SceneSurface& surface : layer.surfaces) {
    surfaces.push_back({{"isovalue", surface.isovalue}, {"opacity", surface.opacity}});
  }
  Json json = {{"name", layer.name},       {"group", layer.group}, {"stores", layer.stores},
               {"visible", layer.visible}, {"surfaces", surfaces}, {"transform", nullptr}};
  if (layer.transform) json["transform"] = *layer.transform;
  const LayerStore found = open_layer(file, layer);
  if (!found.store) {
    json["error"] = found.error;
    return json;
  }
  const Index3 voxels = found.store->info().grid.voxels;
  json["contentId"] = found.store->content();
  json["fileBytes"] = found.store->info().file_bytes;
  json["voxels"] = {voxels.x, voxels.y, voxels.z};
  return json;
}

std::string layer_text(const SceneFile& file, const SceneLayer& layer) {
  std::string text = store_at(layer, first_step(file.scene()));
  if (layer.stores.size() > 1) text += fmt::format(" and {} more", layer.stores.size() - 1);
  const LayerStore found = open_layer(file, layer);
  if (found.store) {
    const Index3 n = found.store->info().grid.voxels;
    text += fmt::format(", {} × {} × {} voxels, {}", n.x, n.y, n.z,
                        format_bytes(found.store->info().file_bytes));
  } else {
    text += ", cannot be read: " + found.error;
  }
  for (const SceneSurface& surface : layer.surfaces) {
    text += fmt::format(", isovalue {:.6g}", surface.isovalue);
    if (surface.opacity < 1)
      text += fmt::format(" ({:.0f} % opaque)", 100 * double(surface.opacity));
  }
  if (layer.transform) text += ", transformed";
  if (!layer.visible) text += ", hidden";
  return text;
}

}  // namespace

int print_scene(const SceneFile& file, bool as_json) {
  const Scene& scene = file.scene();
  if (as_json) {
    Json layers = Json::array();
    for (const SceneLayer& layer : scene.layers) layers.push_back(layer_json(file, layer));
    Json json = {{"kind", file.is_bundle() ? "bundle" : "scene"},
                 {"name", scene.name},
                 {"layers", std::move(layers)}};
    if (scene.time) json["time"] = {{"unit", scene.time->unit}, {"steps", scene.time->values}};
    if (file.is_bundle()) {
      json["fileBytes"] = file.bundle().file_bytes;
      json["headerBytes"] = file.bundle().header_bytes;
      json["coarseBytes"] = file.bundle().coarse_bytes;
    }
    fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
    return kSuccess;
  }
  print_line(file.is_bundle() ? "bundle" : "scene", scene.name);
  if (file.is_bundle()) {
    const BundleHeader& bundle = file.bundle();
    print_line("size", fmt::format("{} in {} stores; {} for a first picture",
                                   format_bytes(bundle.file_bytes), bundle.stores.size(),
                                   format_bytes(bundle.header_bytes + bundle.coarse_bytes)));
  }
  if (scene.time) {
    const auto& values = scene.time->values;
    print_line("time", fmt::format("{} steps, {:.6g} to {:.6g} {}", values.size(), values.front(),
                                   values.back(), scene.time->unit));
  }
  for (size_t i = 0; i < scene.layers.size(); ++i) {
    const SceneLayer& layer = scene.layers[i];
    print_line(layer.name.empty() ? fmt::format("layer {}", i) : layer.name,
               layer_text(file, layer));
  }
  return kSuccess;
}

}  // namespace isosplat::cli
