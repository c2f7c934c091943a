#include "native/cli/render_settings.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "native/scene/layer_surfaces.h"

namespace isosplat::cli {
namespace {

static_assert(kSurfaceColours.size() >= render::kMaxIsosurfaces);

/// "rrggbb" or "rrggbbaa", with or without "#".
std::optional<std::array<float, 4>> parse_colour(std::string_view text) {
  if (text == "transparent") return std::array<float, 4>{1, 1, 1, 0};
  if (!text.empty() && text[0] == '#') text.remove_prefix(1);
  if (text.size() != 6 && text.size() != 8) return std::nullopt;
  std::array<float, 4> colour{0, 0, 0, 1};
  for (size_t i = 0; 2 * i < text.size(); ++i) {
    int value = 0;
    const auto [end, error] =
        std::from_chars(text.data() + 2 * i, text.data() + 2 * i + 2, value, 16);
    if (error != std::errc{} || end != text.data() + 2 * i + 2) return std::nullopt;
    colour[i] = static_cast<float>(value) / 255;
  }
  return colour;
}

/// Sets each of these settings that the option names.
void set_floats(const std::vector<double>& numbers, std::initializer_list<float*> settings) {
  size_t i = 0;
  for (float* setting : settings) {
    if (i < numbers.size()) *setting = static_cast<float>(numbers[i++]);
  }
}

/// Changes the numbers that options state.
void set_light(const RenderCall& call, render::LightSettings& light) {
  set_floats(call.light, {&light.azimuth, &light.elevation});
  set_floats(call.light_strength, {&light.key, &light.sky, &light.rim});
  set_floats(call.material, {&light.highlight, &light.roughness});
  set_floats(call.occlusion, {&light.occlusion, &light.occlusion_radius});
  set_floats(call.shadow, {&light.shadow, &light.shadow_softness});
}

/// The isosurfaces with their colours and opacities.
Result<std::vector<render::Isosurface>> isosurfaces_of(const RenderCall& call) {
  std::vector<render::Isosurface> isosurfaces;
  if (call.isovalues.size() > render::kMaxIsosurfaces) {
    return fail(Status::invalid_argument,
                fmt::format("--isovalue: expected at most {} isovalues, found {}",
                            render::kMaxIsosurfaces, call.isovalues.size()));
  }
  for (size_t i = 0; i < call.isovalues.size(); ++i) {
    render::Isosurface surface{call.isovalues[i], kSurfaceColours[i], 1};
    if (i < call.colours.size()) {
      const auto colour = parse_colour(call.colours[i]);
      if (!colour) {
        return fail(Status::invalid_argument,
                    fmt::format("--colour: expected rrggbb or rrggbbaa, such as d6a08c, found '{}'",
                                call.colours[i]));
      }
      surface.colour = {(*colour)[0], (*colour)[1], (*colour)[2]};
      surface.opacity = (*colour)[3];
    }
    if (i < call.opacities.size()) surface.opacity = static_cast<float>(call.opacities[i]);
    isosurfaces.push_back(surface);
  }
  return isosurfaces;
}

}  // namespace

Result<render::RenderSettings> render_settings(const RenderCall& call) {
  render::RenderSettings settings;
  settings.kind = call.kind == "quad"      ? render::SplatKind::quad
                  : call.kind == "ellipse" ? render::SplatKind::ellipse
                                           : render::SplatKind::exact;
  settings.shading = call.shading == "smooth" ? render::Shading::smooth : render::Shading::exact;
  auto isosurfaces = isosurfaces_of(call);
  if (!isosurfaces) return tl::unexpected(isosurfaces.error());
  settings.isosurfaces = *std::move(isosurfaces);
  const auto background = parse_colour(call.background);
  if (!background) {
    return fail(Status::invalid_argument,
                fmt::format("--background: expected rrggbb, rrggbbaa or transparent, found '{}'",
                            call.background));
  }
  settings.background = *background;
  constexpr std::array kColourBy = {"isosurface", "isovalue", "gradient",
                                    "depth",      "level",    "error"};
  constexpr std::array kMaps = {"viridis", "magma", "cividis", "turbo"};
  for (size_t i = 0; i < kColourBy.size(); ++i) {
    if (call.colour_by == kColourBy[i]) settings.colour_by = static_cast<render::ColourBy>(i);
  }
  for (size_t i = 0; i < kMaps.size(); ++i) {
    if (call.colour_map == kMaps[i]) settings.colour_map = static_cast<render::ColourMap>(i);
  }
  if (call.colour_range.size() == 2) {
    settings.colour_low = call.colour_range[0];
    settings.colour_high = call.colour_range[1];
  }
  if (!call.field.empty()) {
    settings.colour_by = render::ColourBy::field;
    settings.field_steps = call.field_steps;
    settings.field_lines = call.field_lines;
    settings.field_scale = call.field_scale == "logarithmic" ? render::FieldScale::logarithmic
                           : call.field_scale == "symmetric" ? render::FieldScale::symmetric
                                                             : render::FieldScale::linear;
  }
  if (call.clip_box.size() == 6) {
    settings.clip_box_low = {call.clip_box[0], call.clip_box[1], call.clip_box[2]};
    settings.clip_box_high = {call.clip_box[3], call.clip_box[4], call.clip_box[5]};
  }
  for (const auto& [x, y, z, offset] : call.clip_planes) {
    if (x == 0 && y == 0 && z == 0) {
      return fail(Status::invalid_argument,
                  "--clip-plane: expected X,Y,Z,OFFSET with a normal X,Y,Z other than 0,0,0, found "
                  "the normal 0,0,0");
    }
    settings.clip_planes.push_back({{x, y, z}, offset});
  }
  settings.clip_caps = call.clip_caps;
  settings.projected = !call.unprojected;
  set_light(call, settings.light);
  settings.eye_dome = static_cast<float>(call.eye_dome);
  return settings;
}

void apply_scene_settings(const RenderCall& call, const Scene& scene, const ScenePicture& picture,
                          render::RenderSettings& settings) {
  const render::RenderSettings stated = settings;
  settings.light = {};
  settings.clip_planes.clear();
  apply_scene(scene, picture, settings);
  const auto keep = [&](const char* option, auto... members) {
    if (call.given.contains(option)) ((settings.*members = stated.*members), ...);
  };
  using Settings = render::RenderSettings;
  keep("--kind", &Settings::kind);
  keep("--shading", &Settings::shading);
  keep("--colour-by", &Settings::colour_by);
  keep("--field", &Settings::colour_by, &Settings::field_scale, &Settings::field_steps,
       &Settings::field_lines);
  keep("--colour-map", &Settings::colour_map);
  keep("--range", &Settings::colour_low, &Settings::colour_high);
  keep("--background", &Settings::background);
  keep("--eye-dome", &Settings::eye_dome);
  keep("--clip-box", &Settings::clip_box_low, &Settings::clip_box_high);
  keep("--clip-plane", &Settings::clip_planes);
  set_light(call, settings.light);
}

render::Camera render_camera(const RenderCall& call, const VolumeGrid& grid, double aspect) {
  const bool orthographic = call.projection == "orthographic";
  if (const auto& c = call.camera; c.size() >= 6) {
    return {{c[3], c[4], c[5]},       c[2],        c[0], c[1], c.size() > 6 ? c[6] : 0,
            c.size() > 7 ? c[7] : 30, orthographic};
  }
  render::Camera camera = render::default_camera(grid, aspect, orthographic);
  // The whole volume stays in view whatever the field of view is.
  const auto spread = [&](double degrees) {
    const double half = degrees / 2 / 57.29578;
    return orthographic ? std::tan(half) : std::sin(half);
  };
  const double default_distance = camera.distance * spread(camera.field_of_view);
  camera.azimuth = call.azimuth;
  camera.elevation = call.elevation;
  camera.roll = call.roll;
  camera.field_of_view = call.field_of_view;
  camera.distance =
      call.distance > 0 ? call.distance : default_distance / spread(call.field_of_view);
  camera.distance /= call.zoom;
  if (call.target.size() == 3) camera.target = {call.target[0], call.target[1], call.target[2]};
  return camera;
}

}  // namespace isosplat::cli
