#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "shared/core/scene/scene.h"

namespace isosplat {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxText = 1024;  // of names, units and paths, in bytes
constexpr double kMaxNumber = 1e300;
constexpr double kMaxInteger = 9007199254740992.0;  // 2^53: beyond it, numbers of JSON are rounded

/// The value that was found, short enough for a message.
std::string shown(const Json& json) {
  constexpr size_t kMost = 40;
  std::string text = json.is_structured()
                         ? std::string(json.is_array() ? "a list of " : "an object of ") +
                               std::to_string(json.size())
                         : json.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > kMost) text = text.substr(0, kMost) + "…";
  return text;
}

/// A member of the document, with its path for messages. All functions report the first fault, and
/// return a value of their type after it.
class Reader {
 public:
  Reader(const Json* json, std::string path, std::optional<Error>& fault)
      : json_(json), path_(std::move(path)), fault_(fault) {}

  bool exists() const { return json_ != nullptr && !json_->is_null(); }

  Reader at(const char* key) const {
    const Json* found = nullptr;
    if (json_ && json_->is_object()) {
      if (const auto it = json_->find(key); it != json_->end()) found = &*it;
    }
    return {found, path_.empty() ? key : path_ + "." + key, fault_};
  }
  Reader at(size_t index) const {
    return {&(*json_)[index], path_ + "[" + std::to_string(index) + "]", fault_};
  }

  void refuse(const std::string& expected) const {
    if (fault_) return;
    fault_ = Error{Status::malformed_header, "scene: " + (path_.empty() ? "" : path_ + ": ") +
                                                 "expected " + expected + ", found " +
                                                 (json_ ? shown(*json_) : "nothing")};
  }

  void require_object(const char* expected) const {
    if (!json_ || !json_->is_object()) refuse(expected);
  }
  /// The number of entries of a list; 0 after a fault.
  size_t list(size_t least, size_t most) const {
    if (json_ && json_->is_array() && json_->size() >= least && json_->size() <= most) {
      return json_->size();
    }
    refuse("a list of " + std::to_string(least) +
           (least == most ? "" : " to " + std::to_string(most)));
    return 0;
  }
  std::string text(size_t most = kMaxText) const {
    if (json_ && json_->is_string()) {
      const auto& found = json_->get_ref<const std::string&>();
      if (found.size() <= most) return found;
    }
    refuse("a text of at most " + std::to_string(most) + " bytes");
    return {};
  }
  double number(double least = -kMaxNumber, double most = kMaxNumber) const {
    if (json_ && json_->is_number()) {
      const double found = json_->get<double>();
      if (found >= least && found <= most) return found;
    }
    const auto plain = [](double value) {
      std::string digits = std::to_string(value);
      digits.erase(digits.find_last_not_of('0') + 1, std::string::npos);
      if (digits.back() == '.') digits.pop_back();
      return digits;
    };
    if (std::abs(least) >= kMaxNumber && std::abs(most) >= kMaxNumber) {
      refuse("a finite number");
    } else {
      refuse("a number from " + plain(least) + " to " +
             (most >= kMaxNumber ? "1e300" : plain(most)));
    }
    return std::max(least, std::min(most, 0.0));
  }
  /// Up to kMaxInteger.
  double integer(double least) const {
    if (json_ && json_->is_number()) {
      const double found = json_->get<double>();
      if (found >= least && found <= kMaxInteger && found == std::floor(found)) return found;
    }
    refuse(least < 0 ? "an integer from -2^53 to 2^53" : "an integer from 0 to 2^53");
    return 0;
  }
  bool flag() const {
    if (json_ && json_->is_boolean()) return json_->get<bool>();
    refuse("true or false");
    return false;
  }
  Vec3d vector(double least = -kMaxNumber, double most = kMaxNumber) const {
    if (list(3, 3) == 0) return {};
    return {at(size_t{0}).number(least, most), at(1).number(least, most),
            at(2).number(least, most)};
  }
  /// "#rrggbb" or, with alpha, "#rrggbbaa".
  std::array<float, 4> colour(bool with_alpha) const {
    std::array<float, 4> colour{0, 0, 0, 1};
    const char* const expected =
        with_alpha ? "a colour as #rrggbb or #rrggbbaa" : "a colour as #rrggbb";
    const std::string found = json_ && json_->is_string() ? json_->get<std::string>() : "";
    const bool is_form = (found.size() == 7 || (with_alpha && found.size() == 9)) &&
                         found[0] == '#' &&
                         found.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
    if (!is_form) {
      refuse(expected);
      return colour;
    }
    for (size_t i = 0; 2 * i + 1 < found.size(); ++i) {
      colour[i] =
          static_cast<float>(std::strtol(found.substr(2 * i + 1, 2).c_str(), nullptr, 16)) / 255;
    }
    return colour;
  }

 private:
  const Json* json_;
  std::string path_;
  std::optional<Error>& fault_;
};

SceneSurface read_surface(const Reader& in) {
  SceneSurface surface;
  in.require_object("a surface");
  surface.isovalue = in.at("isovalue").number();
  if (const Reader colour = in.at("colour"); colour.exists()) {
    const auto rgba = colour.colour(/*with_alpha=*/false);
    surface.colour = {rgba[0], rgba[1], rgba[2]};
  }
  if (const Reader opacity = in.at("opacity"); opacity.exists()) {
    surface.opacity = static_cast<float>(opacity.number(0, 1));
  }
  return surface;
}

AffineTransform read_transform(const Reader& in) {
  AffineTransform transform{};
  if (in.list(16, 16) == 0) return transform;
  for (size_t i = 0; i < 16; ++i) transform[i] = in.at(i).number();
  for (size_t i = 12; i < 16; ++i) {
    if (transform[i] != (i == 15 ? 1 : 0)) in.at(i).refuse(i == 15 ? "1" : "0");
  }
  return transform;
}

SceneLabel read_label(const Reader& in) {
  in.require_object("a label");
  return {static_cast<int64_t>(in.at("value").integer(-kMaxInteger)),
          static_cast<uint64_t>(in.at("voxels").integer(0)), in.at("volume").number(0)};
}

SceneLayer read_layer(const Reader& in, size_t steps) {
  SceneLayer layer;
  in.require_object("a layer");
  if (const Reader name = in.at("name"); name.exists()) layer.name = name.text();
  if (const Reader group = in.at("group"); group.exists()) layer.group = group.text();
  if (const Reader stores = in.at("stores"); steps > 0 && stores.exists()) {
    const size_t count = stores.list(steps, steps);
    for (size_t i = 0; i < count; ++i) layer.stores.push_back(stores.at(i).text());
  } else {
    // A layer that does not change with time has one store for all steps.
    layer.stores.push_back(in.at("store").text());
  }
  for (size_t i = 0; i < layer.stores.size(); ++i) {
    if (layer.stores[i].empty()) in.refuse("a layer with a store");
  }
  if (const Reader surfaces = in.at("surfaces"); surfaces.exists()) {
    const size_t count = surfaces.list(0, kMaxSurfacesOfLayer);
    for (size_t i = 0; i < count; ++i) layer.surfaces.push_back(read_surface(surfaces.at(i)));
  }
  if (const Reader visible = in.at("visible"); visible.exists()) layer.visible = visible.flag();
  if (const Reader transform = in.at("transform"); transform.exists()) {
    layer.transform = read_transform(transform);
  }
  if (const Reader label = in.at("label"); label.exists()) layer.label = read_label(label);
  return layer;
}

SceneTime read_time(const Reader& in) {
  SceneTime time;
  const Reader steps = in.at("steps");
  const size_t count = steps.list(1, kMaxSteps);
  for (size_t i = 0; i < count; ++i) {
    time.values.push_back(steps.at(i).number());
    if (i > 0 && time.values[i] <= time.values[i - 1]) {
      steps.at(i).refuse("a number above that of the step before");
    }
  }
  if (const Reader unit = in.at("unit"); unit.exists()) time.unit = unit.text(64);
  return time;
}

SceneCamera read_camera(const Reader& in) {
  SceneCamera camera;
  camera.target = in.at("target").vector();
  camera.distance = in.at("distance").number(1e-300);
  const auto angle = [&](const char* key, double& value, double least, double most) {
    if (const Reader found = in.at(key); found.exists()) value = found.number(least, most);
  };
  angle("azimuth", camera.azimuth, -1e6, 1e6);
  angle("elevation", camera.elevation, -90, 90);
  angle("roll", camera.roll, -1e6, 1e6);
  angle("field_of_view", camera.field_of_view, 1, 120);
  if (const Reader found = in.at("orthographic"); found.exists())
    camera.orthographic = found.flag();
  return camera;
}

SceneClip read_clip(const Reader& in) {
  SceneClip clip;
  if (const Reader box = in.at("box"); box.exists()) {
    clip.low = box.at("low").vector(0, 1);
    clip.high = box.at("high").vector(0, 1);
  }
  if (const Reader planes = in.at("planes"); planes.exists()) {
    const size_t count = planes.list(0, kMaxScenePlanes);
    for (size_t i = 0; i < count; ++i) {
      const Reader plane = planes.at(i);
      clip.planes.push_back({plane.at("normal").vector(-1e9, 1e9), plane.at("offset").number()});
      const Vec3d normal = clip.planes.back().normal;
      if (!(length(normal) > 0)) plane.at("normal").refuse("a normal that is not 0");
    }
  }
  if (const Reader caps = in.at("caps"); caps.exists()) clip.caps = caps.flag();
  return clip;
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
  const Reader root(&json, "", fault);
  const Json* format = json.is_object() && json.contains("format") ? &json["format"] : nullptr;
  if (!format || *format != "isosplat-scene") {
    return fail(Status::malformed_header, "scene: format: expected \"isosplat-scene\", found " +
                                              (format ? shown(*format) : "nothing"));
  }
  const Reader version = root.at("version");
  if (const double found = version.number(1); !fault && found != 1) {
    return fail(Status::unsupported_version, "scene: version: expected 1, found " +
                                                 shown(json["version"]) + ": use a newer Isosplat");
  }
  Scene scene;
  if (const Reader name = root.at("name"); name.exists()) scene.name = name.text();
  if (const Reader time = root.at("time"); time.exists()) scene.time = read_time(time);
  const Reader layers = root.at("layers");
  const size_t count = layers.list(1, kMaxLayers);
  for (size_t i = 0; i < count && !fault; ++i) {
    scene.layers.push_back(read_layer(layers.at(i), scene.time ? scene.time->values.size() : 0));
  }
  if (const Reader camera = root.at("camera"); camera.exists()) scene.camera = read_camera(camera);
  if (const Reader clip = root.at("clip"); clip.exists()) scene.clip = read_clip(clip);
  if (const Reader background = root.at("background"); background.exists()) {
    scene.background = background.colour(/*with_alpha=*/true);
  }
  if (fault) return tl::unexpected(*fault);
  return scene;
}

}  // namespace isosplat
