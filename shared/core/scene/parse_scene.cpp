#include <nlohmann/json.hpp>

#include "shared/core/scene/parse_picture.h"
#include "shared/core/scene/scene.h"
#include "shared/core/scene/scene_member.h"

namespace isosplat {
namespace {

using Json = nlohmann::json;

SceneSurface read_surface(const SceneMember& in) {
  SceneSurface surface;
  in.require_object("a surface");
  surface.isovalue = in.at("isovalue").number();
  if (const SceneMember colour = in.at("colour"); colour.exists()) {
    const auto rgba = colour.colour(/*with_alpha=*/false);
    surface.colour = {rgba[0], rgba[1], rgba[2]};
  }
  if (const SceneMember opacity = in.at("opacity"); opacity.exists()) {
    surface.opacity = static_cast<float>(opacity.number(0, 1));
  }
  return surface;
}

AffineTransform read_transform(const SceneMember& in) {
  AffineTransform transform{};
  if (in.list(16, 16) == 0) return transform;
  for (size_t i = 0; i < 16; ++i) transform[i] = in.at(i).number();
  for (size_t i = 12; i < 16; ++i) {
    if (transform[i] != (i == 15 ? 1 : 0)) in.at(i).refuse(i == 15 ? "1" : "0");
  }
  return transform;
}

SceneLabel read_label(const SceneMember& in) {
  in.require_object("a label");
  return {static_cast<int64_t>(in.at("value").integer(-kMaxSceneInteger)),
          static_cast<uint64_t>(in.at("voxels").integer(0)), in.at("volume").number(0)};
}

SceneLayer read_layer(const SceneMember& in, size_t steps) {
  SceneLayer layer;
  in.require_object("a layer");
  if (const SceneMember name = in.at("name"); name.exists()) layer.name = name.text();
  if (const SceneMember group = in.at("group"); group.exists()) layer.group = group.text();
  if (const SceneMember whole = in.at("part_of"); whole.exists()) layer.part_of = whole.text();
  if (const SceneMember stores = in.at("stores"); steps > 0 && stores.exists()) {
    const size_t count = stores.list(steps, steps);
    for (size_t i = 0; i < count; ++i) layer.stores.push_back(stores.at(i).text());
  } else {
    // A layer that does not change with time has one store for all steps.
    layer.stores.push_back(in.at("store").text());
  }
  for (size_t i = 0; i < layer.stores.size(); ++i) {
    if (layer.stores[i].empty()) in.refuse("a layer with a store");
  }
  if (const SceneMember surfaces = in.at("surfaces"); surfaces.exists()) {
    const size_t count = surfaces.list(0, kMaxSurfacesOfLayer);
    for (size_t i = 0; i < count; ++i) layer.surfaces.push_back(read_surface(surfaces.at(i)));
  }
  if (const SceneMember visible = in.at("visible"); visible.exists())
    layer.visible = visible.flag();
  if (const SceneMember transform = in.at("transform"); transform.exists()) {
    layer.transform = read_transform(transform);
  }
  if (const SceneMember label = in.at("label"); label.exists()) layer.label = read_label(label);
  return layer;
}

SceneTime read_time(const SceneMember& in) {
  SceneTime time;
  const SceneMember steps = in.at("steps");
  const size_t count = steps.list(1, kMaxSteps);
  for (size_t i = 0; i < count; ++i) {
    time.values.push_back(steps.at(i).number());
    if (i > 0 && time.values[i] <= time.values[i - 1]) {
      steps.at(i).refuse("a number above that of the step before");
    }
  }
  if (const SceneMember unit = in.at("unit"); unit.exists()) time.unit = unit.text(64);
  time.step = in.at("step").index(count);
  return time;
}

}  // namespace

Result<Scene> parse_scene(std::string_view text) {
  if (text.size() > kMaxSceneBytes) {
    return fail(Status::malformed_header, "scene: expected at most " +
                                              std::to_string(kMaxSceneBytes) + " bytes, found " +
                                              std::to_string(text.size()));
  }
  const Json json = Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) {
    return fail(Status::malformed_header,
                "scene: expected JSON in UTF-8: check it with a JSON tool");
  }
  std::optional<Error> fault;
  const SceneMember root(&json, "", fault);
  const Json* format = json.is_object() && json.contains("format") ? &json["format"] : nullptr;
  if (!format || *format != "isosplat-scene") {
    return fail(Status::malformed_header, "scene: format: expected \"isosplat-scene\", found " +
                                              (format ? shown_json(*format) : "nothing"));
  }
  const SceneMember version = root.at("version");
  if (const double found = version.number(1); !fault && found != 1) {
    return fail(Status::unsupported_version, "scene: version: expected 1, found " +
                                                 shown_json(json["version"]) +
                                                 ": use a newer Isosplat");
  }
  Scene scene;
  if (const SceneMember name = root.at("name"); name.exists()) scene.name = name.text();
  if (const SceneMember time = root.at("time"); time.exists()) scene.time = read_time(time);
  const SceneMember layers = root.at("layers");
  const size_t count = layers.list(1, kMaxLayers);
  for (size_t i = 0; i < count && !fault; ++i) {
    scene.layers.push_back(read_layer(layers.at(i), scene.time ? scene.time->values.size() : 0));
  }
  read_picture(root, scene);
  if (fault) return tl::unexpected(*fault);
  return scene;
}

}  // namespace isosplat
