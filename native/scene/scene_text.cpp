#include "native/scene/scene_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

namespace isosplat {
namespace {

/// Keeps the order in which members are added.
using Json = nlohmann::ordered_json;

/// #rrggbb, or with a fourth component #rrggbbaa.
std::string colour_text(std::span<const float> components) {
  std::string text = "#";
  for (const float component : components) {
    text += fmt::format("{:02x}", static_cast<int>(std::lround(component * 255)));
  }
  return text;
}

Json vector_json(const Vec3d& v) {
  return {v.x, v.y, v.z};
}

Json layer_json(const SceneLayer& layer) {
  Json json = Json::object();
  if (!layer.name.empty()) json["name"] = layer.name;
  if (!layer.group.empty()) json["group"] = layer.group;
  if (!layer.part_of.empty()) json["part_of"] = layer.part_of;
  if (layer.stores.size() == 1) {
    json["store"] = layer.stores.front();
  } else {
    json["stores"] = layer.stores;
  }
  for (const SceneSurface& surface : layer.surfaces) {
    Json each{{"isovalue", surface.isovalue}};
    if (surface.colour) each["colour"] = colour_text(*surface.colour);
    if (surface.opacity != 1) each["opacity"] = surface.opacity;
    json["surfaces"].push_back(std::move(each));
  }
  if (!layer.visible) json["visible"] = false;
  if (layer.transform) json["transform"] = *layer.transform;
  if (const auto& label = layer.label) {
    json["label"] = {{"value", label->value}, {"voxels", label->voxels}, {"volume", label->volume}};
  }
  return json;
}

Json camera_json(const SceneCamera& camera) {
  return {{"target", vector_json(camera.target)},
          {"distance", camera.distance},
          {"azimuth", camera.azimuth},
          {"elevation", camera.elevation},
          {"roll", camera.roll},
          {"field_of_view", camera.field_of_view},
          {"orthographic", camera.orthographic}};
}

/// Null if nothing is cut away.
Json clip_json(const SceneClip& clip) {
  Json json;
  const bool is_whole = clip.low == Vec3d{0, 0, 0} && clip.high == Vec3d{1, 1, 1};
  if (!is_whole) {
    json["box"] = {{"low", vector_json(clip.low)}, {"high", vector_json(clip.high)}};
  }
  for (const ScenePlane& plane : clip.planes) {
    json["planes"].push_back({{"normal", vector_json(plane.normal)}, {"offset", plane.offset}});
  }
  if (clip.caps) json["caps"] = true;
  return json;
}

}  // namespace

std::string scene_text(const Scene& scene) {
  Json json{{"format", "isosplat-scene"}, {"version", 1}};
  if (!scene.name.empty()) json["name"] = scene.name;
  if (scene.time) {
    json["time"]["steps"] = scene.time->values;
    if (!scene.time->unit.empty()) json["time"]["unit"] = scene.time->unit;
  }
  for (const SceneLayer& layer : scene.layers) json["layers"].push_back(layer_json(layer));
  if (scene.camera) json["camera"] = camera_json(*scene.camera);
  if (Json clip = clip_json(scene.clip); !clip.is_null()) json["clip"] = std::move(clip);
  if (scene.background) json["background"] = colour_text(*scene.background);
  // Names come from files: bytes that are not UTF-8 are replaced.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace isosplat
