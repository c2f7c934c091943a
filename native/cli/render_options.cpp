#include "native/cli/render_options.h"

#include <fmt/format.h>

#include <limits>

#include "native/cli/numbers.h"
#include "shared/core/scene/scene.h"

namespace isosplat::cli {
namespace {

void add_output_options(CLI::App* command, RenderCall* call) {
  command->add_option("store", call->store, "A store, a scene or a bundle")->required();
  command->add_option("-i,--isovalue", call->isovalues, "One or several isovalues: 60.5,180.5")
      ->delimiter(',')
      ->check(is_number());
  command->add_option("--step", call->step, "Scenes: the step of time, from 0")
      ->check(is_whole_number(0, kMaxSteps - 1))
      ->capture_default_str();
  command->add_option("-o,--output", call->output, "The PNG file")->capture_default_str();
  command->add_option("--size", call->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command
      ->add_option("--turntable", call->turntable,
                   "N pictures on a circle around the target: OUTPUT-000.png, OUTPUT-001.png, …")
      ->check(is_whole_number(1, 100'000));
  command->add_flag("--force", call->force, "Replace any files of these names");
}

void add_colour_options(CLI::App* command, RenderCall* call) {
  command->add_option("--colour,--color", call->colours, "rrggbb or rrggbbaa for each isovalue")
      ->delimiter(',');
  command->add_option("--opacity", call->opacities, "0 to 1, for each isovalue")
      ->delimiter(',')
      ->check(is_number(0, 1));
  command->add_option("--background", call->background, "rrggbb, rrggbbaa or transparent")
      ->capture_default_str();
  command->add_option("--colour-by,--color-by", call->colour_by, "Quantity shown as colour")
      ->check(CLI::IsMember({"isosurface", "isovalue", "gradient", "depth", "level", "error"}))
      ->capture_default_str();
  command->add_option("--colour-map,--color-map", call->colour_map, "Colour map for --colour-by")
      ->check(CLI::IsMember({"viridis", "magma", "cividis", "turbo"}))
      ->capture_default_str();
  command->add_option("--range", call->colour_range, "LOW,HIGH: the values at the map's ends")
      ->delimiter(',')
      ->check(is_number())
      ->expected(2);
}

void add_camera_options(CLI::App* command, RenderCall* call) {
  command->add_option("--azimuth", call->azimuth, "Degrees: 0 from the front, 90 from the left")
      ->check(is_number())
      ->capture_default_str();
  command->add_option("--elevation", call->elevation, "Degrees above the horizon")
      ->check(is_number())
      ->capture_default_str();
  command->add_option("--roll", call->roll, "Degrees about the viewing direction")
      ->check(is_number())
      ->capture_default_str();
  command
      ->add_option("--projection", call->projection,
                   "orthographic: rays are parallel, and sizes do not depend on the distance")
      ->check(CLI::IsMember({"perspective", "orthographic"}))
      ->capture_default_str();
  command->add_option("--field-of-view", call->field_of_view, "Degrees, vertical")
      ->check(is_number(1, 120))
      ->capture_default_str();
  command
      ->add_option("--distance", call->distance,
                   "From the eye to the target in world units (0: the whole volume is in view)")
      ->check(is_number(0, std::numeric_limits<double>::max()));
  command->add_option("--zoom", call->zoom, "Divides the distance")->check(is_above_zero());
  command
      ->add_option("--camera", call->camera,
                   "AZIMUTH,ELEVATION,DISTANCE,X,Y,Z[,ROLL[,FIELD_OF_VIEW]]: the whole camera, as "
                   "in the page's URL")
      ->delimiter(',')
      ->check(is_number())
      ->expected(6, 8);
  command->add_option("--target", call->target, "X,Y,Z in world units: where the camera looks")
      ->delimiter(',')
      ->check(is_number())
      ->expected(3);
}

void add_light_options(CLI::App* command, RenderCall* call) {
  const render::LightSettings light;
  const auto add = [&](const char* name, std::vector<double>& numbers, const std::string& text,
                       int least, int most) {
    return command->add_option(name, numbers, text)->delimiter(',')->expected(least, most);
  };
  add("--light", call->light,
      fmt::format("AZIMUTH,ELEVATION: direction to the key light in degrees: 0,0 from the eye, "
                  "negative azimuths from the left ({},{})",
                  light.azimuth, light.elevation),
      2, 2)
      ->check(is_number(-180, 180));
  add("--light-strength", call->light_strength,
      fmt::format(
          "KEY[,SKY[,RIM]]: strengths of the key light, of the light from all sides, and of "
          "the light from behind, each 0 to 2 ({},{},{})",
          light.key, light.sky, light.rim),
      1, 3)
      ->check(is_number(0, 2));
  add("--material", call->material,
      fmt::format("HIGHLIGHT[,ROUGHNESS]: strength of highlights, 0 to 2, and roughness, 0.1 to 1 "
                  "({},{})",
                  light.highlight, light.roughness),
      1, 2)
      ->check(is_number(0, 2));
  add("--occlusion", call->occlusion,
      fmt::format("STRENGTH[,RADIUS]: ambient occlusion, 0 to 1, and its reach as a share of the "
                  "volume's radius, 0.001 to 1 ({},{})",
                  light.occlusion, light.occlusion_radius),
      1, 2)
      ->check(is_number(0, 1));
  add("--shadow", call->shadow,
      fmt::format("STRENGTH[,SOFTNESS]: shadows of the key light, 0 to 1, and the radius of that "
                  "light at distance 1, 0.01 to 0.5 ({},{})",
                  light.shadow, light.shadow_softness),
      1, 2)
      ->check(is_number(0, 1));
  command
      ->add_option("--eye-dome", call->eye_dome,
                   "Strength of edge shading (eye-dome lighting), 0 to 1")
      ->check(is_number(0, 1))
      ->capture_default_str();
}

void add_scene_options(CLI::App* command, RenderCall* call) {
  command->add_option("--kind", call->kind, "Kind of splats")
      ->check(CLI::IsMember({"quad", "ellipse", "exact"}))
      ->capture_default_str();
  command
      ->add_option(
          "--shading", call->shading,
          "smooth: normals are continuous; exact: the gradient of each cell (not of quads)")
      ->check(CLI::IsMember({"smooth", "exact"}))
      ->capture_default_str();
  command
      ->add_option("--clip-box", call->clip_box,
                   "X0,Y0,Z0,X1,Y1,Z1 as fractions of the volume: only this box is drawn")
      ->delimiter(',')
      ->check(is_number())
      ->expected(6);
  command
      ->add_option("--clip-plane", call->clip_planes,
                   fmt::format("X,Y,Z,OFFSET: draws only points whose dot product with the normal "
                               "X,Y,Z is at least OFFSET (world units); up to {} times",
                               render::kMaxClipPlanes))
      ->delimiter(',')
      ->check(is_number())
      ->expected(1, render::kMaxClipPlanes);
  command->add_flag("--clip-caps", call->clip_caps,
                    "Closes the faces at which --clip-box and --clip-plane cut the part of the "
                    "volume whose values are at least the isovalue");
  command->add_option("--level", call->level, "0 is the finest (default: by --samples)")
      ->check(is_whole_number(0, 32));
  command
      ->add_option("--samples", call->samples,
                   "Without --level: draws the finest level with at most so many samples")
      ->check(is_whole_number(0, std::numeric_limits<int64_t>::max()))
      ->capture_default_str();
  command->add_flag("--unprojected", call->unprojected,
                    "Does not project samples onto the isosurface (quads and ellipses)");
  command->add_flag("--aliased", call->aliased,
                    "One picture instead of the mean of eight: faster, with jagged edges, without "
                    "ambient occlusion and shadows");
}

}  // namespace

void add_render_options(CLI::App* command, RenderCall* call) {
  add_output_options(command, call);
  add_colour_options(command, call);
  add_camera_options(command, call);
  add_light_options(command, call);
  add_scene_options(command, call);
}

}  // namespace isosplat::cli
