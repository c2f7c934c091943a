#include "shared/core/scene/parse_picture.h"

namespace isosplat {
namespace {

SceneCamera read_camera(const SceneMember& in) {
  SceneCamera camera;
  camera.target = in.at("target").vector();
  camera.distance = in.at("distance").number(1e-300);
  const auto angle = [&](const char* key, double& value, double least, double most) {
    if (const SceneMember found = in.at(key); found.exists()) value = found.number(least, most);
  };
  angle("azimuth", camera.azimuth, -1e6, 1e6);
  angle("elevation", camera.elevation, -90, 90);
  angle("roll", camera.roll, -1e6, 1e6);
  angle("field_of_view", camera.field_of_view, 1, 120);
  if (const SceneMember found = in.at("orthographic"); found.exists()) {
    camera.orthographic = found.flag();
  }
  return camera;
}

ScenePlane read_plane(const SceneMember& in) {
  const ScenePlane plane{in.at("normal").vector(-1e9, 1e9), in.at("offset").number()};
  if (!(length(plane.normal) > 0)) in.at("normal").refuse("a normal that is not 0");
  return plane;
}

SceneClip read_clip(const SceneMember& in) {
  SceneClip clip;
  if (const SceneMember box = in.at("box"); box.exists()) {
    clip.low = box.at("low").vector(0, 1);
    clip.high = box.at("high").vector(0, 1);
  }
  if (const SceneMember planes = in.at("planes"); planes.exists()) {
    const size_t count = planes.list(0, kMaxScenePlanes);
    for (size_t i = 0; i < count; ++i) clip.planes.push_back(read_plane(planes.at(i)));
  }
  if (const SceneMember caps = in.at("caps"); caps.exists()) clip.caps = caps.flag();
  return clip;
}

SceneSlices read_slices(const SceneMember& in) {
  SceneSlices slices;
  in.require_object("slices");
  if (const SceneMember along = in.at("along"); along.exists()) {
    const size_t count = along.list(3, 3);
    for (size_t axis = 0; axis < count; ++axis) {
      const SceneMember share = along.at(axis);
      if (share.exists()) slices.along[axis] = share.number(0, 1);
    }
  }
  if (const SceneMember plane = in.at("plane"); plane.exists()) slices.plane = read_plane(plane);
  if (const SceneMember range = in.at("range"); range.exists() && range.list(2, 2) > 0) {
    slices.range = {range.at(size_t{0}).number(), range.at(1).number()};
    if (!(slices.range->low < slices.range->high)) range.at(1).refuse("a number above the first");
  }
  if (const SceneMember mapped = in.at("mapped"); mapped.exists()) slices.mapped = mapped.flag();
  return slices;
}

SceneLight read_light(const SceneMember& in) {
  SceneLight light;
  in.require_object("a light");
  const auto read = [&](const char* key, std::optional<double>& value, double least, double most) {
    if (const SceneMember found = in.at(key); found.exists()) value = found.number(least, most);
  };
  // The ranges of LightSettings.
  read("azimuth", light.azimuth, -180, 180);
  read("elevation", light.elevation, -90, 90);
  read("key", light.key, 0, 2);
  read("sky", light.sky, 0, 2);
  read("rim", light.rim, 0, 2);
  read("highlight", light.highlight, 0, 2);
  read("roughness", light.roughness, 0.1, 1);
  read("occlusion", light.occlusion, 0, 1);
  read("occlusion_radius", light.occlusion_radius, 0.001, 1);
  read("shadow", light.shadow, 0, 1);
  read("shadow_softness", light.shadow_softness, 0.01, 0.5);
  return light;
}

SceneField read_field(const SceneMember& in) {
  SceneField field;
  in.require_object("a field");
  field.name = in.at("name").text(kMaxSceneFieldName);
  if (field.name.empty()) in.at("name").refuse("the name of a field");
  if (const SceneMember scale = in.at("scale"); scale.exists()) {
    field.scale =
        static_cast<SceneFieldScale>(scale.one_of({"linear", "logarithmic", "symmetric"}));
  }
  if (const SceneMember range = in.at("range"); range.exists() && range.list(2, 2) > 0) {
    field.range = {range.at(size_t{0}).number(), range.at(1).number()};
    if (!(field.range->low < field.range->high)) range.at(1).refuse("a number above the first");
    if (field.scale == SceneFieldScale::logarithmic && !(field.range->low > 0)) {
      range.at(size_t{0}).refuse("a number above 0, for a logarithmic scale");
    }
  }
  if (const SceneMember steps = in.at("steps"); steps.exists()) {
    const double count = steps.integer(0);
    if (count == 1 || count > kMaxSceneFieldSteps) {
      steps.refuse("0, or 2 to " + std::to_string(kMaxSceneFieldSteps) + " colours");
    } else {
      field.steps = static_cast<int>(count);
    }
  }
  if (const SceneMember lines = in.at("lines"); lines.exists()) {
    field.lines = lines.number();
    if (field.lines < 0) lines.refuse("0, or a number above 0");
  }
  return field;
}

SceneLook read_look(const SceneMember& in) {
  SceneLook look;
  in.require_object("a look");
  if (const SceneMember kind = in.at("kind"); kind.exists()) {
    look.kind = static_cast<SceneSplats>(kind.one_of({"automatic", "quad", "ellipse", "exact"}));
  }
  if (const SceneMember shading = in.at("shading"); shading.exists()) {
    look.shading = static_cast<SceneShading>(shading.one_of({"smooth", "exact"}));
  }
  if (const SceneMember colour_by = in.at("colour_by"); colour_by.exists()) {
    look.colour_by = static_cast<SceneColouring>(colour_by.one_of(
        {"isosurface", "isovalue", "gradient", "depth", "level", "projection-error", "field"}));
  }
  if (const SceneMember colour_map = in.at("colour_map"); colour_map.exists()) {
    look.colour_map =
        static_cast<SceneColourMap>(colour_map.one_of({"viridis", "magma", "cividis", "turbo"}));
  }
  const SceneMember field = in.at("field");
  if (field.exists()) look.field = read_field(field);
  if (look.colour_by == SceneColouring::field && !field.exists()) {
    field.refuse("the field that colours show");
  }
  if (const SceneMember light = in.at("light"); light.exists()) look.light = read_light(light);
  if (const SceneMember eye_dome = in.at("eye_dome"); eye_dome.exists()) {
    look.eye_dome = eye_dome.number(0, 1);
  }
  return look;
}

SceneMeasuredPoint read_point(const SceneMember& in) {
  SceneMeasuredPoint point;
  point.position = in.at("position").vector();
  if (const SceneMember value = in.at("value"); value.exists()) point.value = value.number();
  if (const SceneMember normal = in.at("normal"); normal.exists()) point.normal = normal.vector();
  if (const SceneMember level = in.at("level"); level.exists()) {
    point.level = static_cast<uint64_t>(level.integer(0));
  }
  if (const SceneMember layer = in.at("layer"); layer.exists()) point.layer = layer.text();
  if (const SceneMember voxel = in.at("voxel"); voxel.exists()) point.voxel = voxel.vector();
  if (const SceneMember field = in.at("field"); field.exists()) {
    field.require_object("a field");
    SceneMeasuredField& measured = point.field.emplace();
    measured.name = field.at("name").text();
    measured.value = field.at("value").number();
    if (const SceneMember units = field.at("units"); units.exists()) measured.units = units.text();
  }
  return point;
}

SceneMeasurement read_measurement(const SceneMember& in) {
  SceneMeasurement measurement;
  measurement.kind = static_cast<SceneMeasurementKind>(
      in.at("kind").one_of({"point", "distance", "path", "angle", "note"}));
  constexpr std::array<std::array<size_t, 2>, 5> kPoints{
      {{1, 1}, {2, 2}, {2, kMaxMeasuredPath}, {3, 3}, {1, 1}}};
  const auto [least, most] = kPoints[static_cast<size_t>(measurement.kind)];
  const SceneMember points = in.at("points");
  const size_t count = points.list(least, most);
  for (size_t i = 0; i < count; ++i) measurement.points.push_back(read_point(points.at(i)));
  const SceneMember text = in.at("text");
  if (text.exists()) measurement.text = text.text();
  if (measurement.kind == SceneMeasurementKind::note && measurement.text.empty()) {
    text.refuse("the text of the note");
  }
  return measurement;
}

std::vector<SceneMeasurement> read_measurements(const SceneMember& in) {
  std::vector<SceneMeasurement> measurements;
  const size_t count = in.list(0, kMaxMeasurements);
  size_t points = 0;
  for (size_t i = 0; i < count; ++i) {
    measurements.push_back(read_measurement(in.at(i)));
    points += measurements.back().points.size();
  }
  if (points > kMaxMeasuredPoints) {
    in.refuse("at most " + std::to_string(kMaxMeasuredPoints) + " points in all");
  }
  return measurements;
}

}  // namespace

void read_picture(const SceneMember& root, Scene& scene) {
  if (const SceneMember camera = root.at("camera"); camera.exists()) {
    scene.camera = read_camera(camera);
  }
  if (const SceneMember clip = root.at("clip"); clip.exists()) scene.clip = read_clip(clip);
  if (const SceneMember slices = root.at("slices"); slices.exists()) {
    scene.slices = read_slices(slices);
  }
  if (const SceneMember look = root.at("look"); look.exists()) scene.look = read_look(look);
  if (const SceneMember background = root.at("background"); background.exists()) {
    scene.background = background.colour(/*with_alpha=*/true);
  }
  if (const SceneMember measurements = root.at("measurements"); measurements.exists()) {
    scene.measurements = read_measurements(measurements);
  }
}

}  // namespace isosplat
