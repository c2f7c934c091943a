#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "native/cli/remote_flags.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::cli {

/// The options of "render".
struct RenderCall {
  std::string store, output = "out.png";
  std::vector<double> isovalues;
  std::string size = "1024x1024";
  std::string kind = "exact", shading = "smooth";
  std::vector<std::string> colours;
  std::vector<double> opacities;
  std::string background = "ffffff";
  std::string colour_by = "isosurface", colour_map = "viridis";
  std::vector<double> colour_range;
  std::string field;  // of the store, shown as colours; empty: none
  std::vector<double> field_range;
  std::string field_scale = "linear";
  int field_steps = 0;
  double field_lines = 0;  // 0: none
  std::vector<double> target, clip_box;
  std::vector<std::array<double, 4>> clip_planes;
  std::vector<double> camera;  // azimuth, elevation, distance, x, y, z, roll, field of view
  double azimuth = 30, elevation = 20, roll = 0, field_of_view = 30;
  std::string projection = "perspective";
  double distance = 0, zoom = 1;
  double eye_dome = render::RenderSettings{}.eye_dome;
  std::vector<double> light, light_strength, material, occlusion, shadow;
  std::optional<uint32_t> level;
  uint64_t samples = uint64_t{64} << 20;
  std::optional<uint64_t> step;  // of a scene; nothing: that which the scene shows first
  int turntable = 0;             // number of pictures; 0: one picture, named `output`
  bool clip_caps = false;
  bool unprojected = false;
  bool aliased = false;
  bool force = false;
  RemoteFlags remote_flags;
  /// The names of the options that were given, such as "--kind": they come before those of a scene.
  std::set<std::string> given;
};

/// Adds the options to the command; parsing writes them to `call`.
void add_render_options(CLI::App* command, RenderCall* call);

}  // namespace isosplat::cli
