#include "native/cli/render_options.h"

#include <fmt/format.h>

#include <limits>

#include "native/cli/numbers.h"
#include "shared/core/scene/scene.h"

namespace isosplat::cli {
namespace {

void add_output_options(CLI::App* command, RenderCall* call) {
  command
      ->add_option("store", call->store,
                   "A store, a scene, a bundle, or an address of a store or a bundle")
      ->required();
  command
      ->add_option("-i,--isovalue", call->isovalues, "One or several isovalues, such as 60.5,180.5")
      ->delimiter(',')
      ->check(is_number());
  command
      ->add_option("--step", call->step,
                   "Scenes: index of the time step, from 0 (default: that which the scene shows "
                   "first)")
      ->check(is_whole_number(0, kMaxSteps - 1));
  command->add_option("-o,--output", call->output, "The PNG file, or a WebP file (.webp)")
      ->capture_default_str();
  command->add_option("--size", call->size, "Size of the picture, WIDTHxHEIGHT in pixels")
      ->capture_default_str();
  command
      ->add_option("--turntable", call->turntable,
                   "Draw N pictures from viewpoints on a circle around the target: OUTPUT-000.png, "
                   "OUTPUT-001.png, …")
      ->check(is_whole_number(1, 100'000));
  command->add_flag("--force", call->force, "Replace any files of these names");
  call->remote_flags.add_to(*command);
}

void add_colour_options(CLI::App* command, RenderCall* call) {
  command
      ->add_option("--colour,--color", call->colours,
                   "Colour of each isosurface: rrggbb or rrggbbaa")
      ->delimiter(',');
  command->add_option("--opacity", call->opacities, "Opacity of each isosurface, 0 to 1")
      ->delimiter(',')
      ->check(is_number(0, 1));
  command
      ->add_option("--background", call->background,
                   "Colour of the background: rrggbb, rrggbbaa or transparent")
      ->capture_default_str();
  command->add_option("--colour-by,--color-by", call->colour_by, "Quantity shown as colour")
      ->check(CLI::IsMember({"isosurface", "isovalue", "gradient", "depth", "level", "error"}))
      ->capture_default_str();
  command->add_option("--colour-map,--color-map", call->colour_map, "Colour map for --colour-by")
      ->check(CLI::IsMember({"viridis", "magma", "cividis", "turbo"}))
      ->capture_default_str();
  command
      ->add_option("--range", call->colour_range, "LOW,HIGH: values at the ends of the colour map")
      ->delimiter(',')
      ->check(is_number())
      ->expected(2);
}

void add_field_options(CLI::App* command, RenderCall* call) {
  CLI::Option* colour_by = command->get_option("--colour-by");
  CLI::Option* field =
      command
          ->add_option(
              "--field", call->field,
              "Show the values of this field of the store in the colours of --colour-map, or "
              "its labels, each in its own colour")
          ->excludes(colour_by);
  command
      ->add_option("--field-range", call->field_range,
                   "LOW,HIGH: values of the field at the ends of the colour map (default: the 1st "
                   "and the 99th percentile in the cells of the isosurfaces)")
      ->delimiter(',')
      ->check(is_number())
      ->expected(2)
      ->needs(field);
  command
      ->add_option(
          "--field-scale", call->field_scale,
          "logarithmic: the range is above 0; symmetric: the middle of the colour map is 0")
      ->check(CLI::IsMember({"linear", "logarithmic", "symmetric"}))
      ->capture_default_str()
      ->needs(field);
  command
      ->add_option("--field-steps", call->field_steps,
                   "Show the field in N colours (default: all colours of the map)")
      ->check(is_whole_number(2, 256))
      ->needs(field);
  command
      ->add_option("--field-lines", call->field_lines,
                   "Draw contour lines where the field is a multiple of INTERVAL; with a "
                   "logarithmic scale, where its logarithm to base 10 is (default: none)")
      ->type_name("INTERVAL")
      ->check(is_above_zero())
      ->needs(field);
}

void add_camera_options(CLI::App* command, RenderCall* call) {
  command
      ->add_option("--azimuth", call->azimuth,
                   "Azimuth of the viewpoint in degrees: 0 is the front, 90 the left")
      ->check(is_number())
      ->capture_default_str();
  command
      ->add_option("--elevation", call->elevation,
                   "Elevation of the viewpoint in degrees above the horizon")
      ->check(is_number())
      ->capture_default_str();
  command
      ->add_option("--roll", call->roll,
                   "Rotation of the camera about the viewing direction, in degrees")
      ->check(is_number())
      ->capture_default_str();
  command
      ->add_option(
          "--projection", call->projection,
          "With orthographic, viewing rays are parallel, and sizes do not depend on the distance")
      ->check(CLI::IsMember({"perspective", "orthographic"}))
      ->capture_default_str();
  command->add_option("--field-of-view", call->field_of_view, "Vertical field of view in degrees")
      ->check(is_number(1, 120))
      ->capture_default_str();
  command
      ->add_option("--distance", call->distance,
                   "Distance from the eye to the target in world units (0: as large as needed to "
                   "show the whole volume)")
      ->check(is_number(0, std::numeric_limits<double>::max()));
  command->add_option("--zoom", call->zoom, "Factor by which the distance is divided")
      ->check(is_above_zero());
  command
      ->add_option("--camera", call->camera,
                   "AZIMUTH,ELEVATION,DISTANCE,X,Y,Z[,ROLL[,FIELD_OF_VIEW]]: the whole camera, as "
                   "in the page's URL")
      ->delimiter(',')
      ->check(is_number())
      ->expected(6, 8);
  command
      ->add_option("--target", call->target,
                   "X,Y,Z in world units: the point at which the camera looks")
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
      fmt::format("AZIMUTH,ELEVATION: direction to the key light in degrees: 0,0 points to the "
                  "eye, negative azimuths point to the left (default: {},{})",
                  light.azimuth, light.elevation),
      2, 2)
      ->check(is_number(-180, 180));
  add("--light-strength", call->light_strength,
      fmt::format("KEY[,SKY[,RIM]]: strengths of the key light, the light from all sides, and the "
                  "light from behind, each 0 to 2 (default: {},{},{})",
                  light.key, light.sky, light.rim),
      1, 3)
      ->check(is_number(0, 2));
  add("--material", call->material,
      fmt::format("HIGHLIGHT[,ROUGHNESS]: strength of highlights, 0 to 2, and roughness, 0.1 to 1 "
                  "(default: {},{})",
                  light.highlight, light.roughness),
      1, 2)
      ->check(is_number(0, 2));
  add("--occlusion", call->occlusion,
      fmt::format("STRENGTH[,RADIUS]: strength of ambient occlusion, 0 to 1, and its radius as a "
                  "fraction of the volume's radius, 0.001 to 1 (default: {},{})",
                  light.occlusion, light.occlusion_radius),
      1, 2)
      ->check(is_number(0, 1));
  add("--shadow", call->shadow,
      fmt::format("STRENGTH[,SOFTNESS]: strength of the key light's shadows, 0 to 1, and radius of "
                  "that light at distance 1, 0.01 to 0.5 (default: {},{})",
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
      ->add_option("--shading", call->shading,
                   "smooth: normals are continuous; exact: normals are the gradients of cells (not "
                   "for quads)")
      ->check(CLI::IsMember({"smooth", "exact"}))
      ->capture_default_str();
  command
      ->add_option("--clip-box", call->clip_box,
                   "X0,Y0,Z0,X1,Y1,Z1 as fractions of the volume: draw only this box")
      ->delimiter(',')
      ->check(is_number())
      ->expected(6);
  command
      ->add_option(
          "--clip-plane", call->clip_planes,
          fmt::format("X,Y,Z,OFFSET in world units: draw only points whose dot product with the "
                      "normal X,Y,Z is at least OFFSET; may be given up to {} times",
                      render::kMaxClipPlanes))
      ->delimiter(',')
      ->check(is_number())
      ->expected(1, render::kMaxClipPlanes);
  command->add_flag("--clip-caps", call->clip_caps,
                    "Close surfaces that --clip-box and --clip-plane cut open: fill the cut faces "
                    "where values are at least the isovalue");
  command
      ->add_option("--level", call->level,
                   "Level of detail; 0 is the finest (default: depends on --samples)")
      ->check(is_whole_number(0, 32));
  command
      ->add_option("--samples", call->samples,
                   "Without --level: draw the finest level that has at most this many samples")
      ->check(is_whole_number(0, std::numeric_limits<int64_t>::max()))
      ->capture_default_str();
  command->add_flag("--unprojected", call->unprojected,
                    "Do not project samples onto the isosurface (quads and ellipses)");
  command->add_flag("--aliased", call->aliased,
                    "Draw one picture instead of the mean of eight. This is faster, but edges are "
                    "jagged, and ambient occlusion and shadows are missing");
}

}  // namespace

void add_render_options(CLI::App* command, RenderCall* call) {
  add_output_options(command, call);
  add_colour_options(command, call);
  add_field_options(command, call);
  add_camera_options(command, call);
  add_light_options(command, call);
  add_scene_options(command, call);
}

}  // namespace isosplat::cli
