#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <optional>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "native/headless/store_scene.h"

namespace isosplat::cli {
namespace {

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
  std::vector<double> target, clip_box;
  std::vector<std::array<double, 4>> clip_planes;
  std::vector<double> camera;  // azimuth, elevation, distance, x, y, z, roll, field of view
  double azimuth = 30, elevation = 20, roll = 0, field_of_view = 30;
  double distance = 0, zoom = 1;
  double eye_dome = RenderSettings{}.eye_dome;
  std::vector<double> light, light_strength, material, occlusion, shadow;
  std::optional<uint32_t> level;
  uint64_t samples = uint64_t{64} << 20;
  int turntable = 0;  // number of pictures; 0: one picture, named `output`
  bool unprojected = false;
  bool aliased = false;
  bool force = false;
};

constexpr int64_t kMaxPictureSize = 16384;  // of each side: the usual limit of OpenGL

// Colours for bone and skin, then those of Okabe and Ito (2008), which people with colour vision
// deficiency can distinguish.
constexpr Vec3f kColours[kMaxIsosurfaces] = {
    {0.90f, 0.85f, 0.74f}, {0.84f, 0.55f, 0.42f}, {0.34f, 0.71f, 0.91f}, {0.00f, 0.62f, 0.45f},
    {0.94f, 0.89f, 0.26f}, {0.00f, 0.45f, 0.70f}, {0.84f, 0.37f, 0.00f}, {0.80f, 0.47f, 0.65f}};

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

LightSettings light_settings(const RenderCall& call) {
  LightSettings light;
  set_floats(call.light, {&light.azimuth, &light.elevation});
  set_floats(call.light_strength, {&light.key, &light.sky, &light.rim});
  set_floats(call.material, {&light.highlight, &light.roughness});
  set_floats(call.occlusion, {&light.occlusion, &light.occlusion_radius});
  set_floats(call.shadow, {&light.shadow, &light.shadow_softness});
  return light;
}

Result<RenderSettings> render_settings(const RenderCall& call) {
  RenderSettings settings;
  settings.kind = call.kind == "quad"      ? SplatKind::quad
                  : call.kind == "ellipse" ? SplatKind::ellipse
                                           : SplatKind::exact;
  settings.shading = call.shading == "smooth" ? Shading::smooth : Shading::exact;
  if (call.isovalues.size() > kMaxIsosurfaces) {
    return fail(Status::invalid_argument,
                fmt::format("--isovalue: expected at most {} isovalues, found {}", kMaxIsosurfaces,
                            call.isovalues.size()));
  }
  for (size_t i = 0; i < call.isovalues.size(); ++i) {
    Isosurface surface{call.isovalues[i], kColours[i], 1};
    if (i < call.colours.size()) {
      const auto colour = parse_colour(call.colours[i]);
      if (!colour) {
        return fail(Status::invalid_argument,
                    fmt::format("--colour {}: expected rrggbb, such as d6a08c", call.colours[i]));
      }
      surface.colour = {(*colour)[0], (*colour)[1], (*colour)[2]};
      surface.opacity = (*colour)[3];
    }
    if (i < call.opacities.size()) surface.opacity = static_cast<float>(call.opacities[i]);
    settings.isosurfaces.push_back(surface);
  }
  const auto background = parse_colour(call.background);
  if (!background) {
    return fail(Status::invalid_argument,
                fmt::format("--background {}: expected rrggbb or transparent", call.background));
  }
  settings.background = *background;
  constexpr std::array kColourBy = {"isosurface", "isovalue", "gradient",
                                    "depth",      "level",    "error"};
  constexpr std::array kMaps = {"viridis", "magma", "cividis", "turbo"};
  for (size_t i = 0; i < kColourBy.size(); ++i) {
    if (call.colour_by == kColourBy[i]) settings.colour_by = static_cast<ColourBy>(i);
  }
  for (size_t i = 0; i < kMaps.size(); ++i) {
    if (call.colour_map == kMaps[i]) settings.colour_map = static_cast<ColourMap>(i);
  }
  if (call.colour_range.size() == 2) {
    settings.colour_low = call.colour_range[0];
    settings.colour_high = call.colour_range[1];
  }
  if (call.clip_box.size() == 6) {
    settings.clip_box_low = {call.clip_box[0], call.clip_box[1], call.clip_box[2]};
    settings.clip_box_high = {call.clip_box[3], call.clip_box[4], call.clip_box[5]};
  }
  for (const auto& [x, y, z, offset] : call.clip_planes) {
    if (x == 0 && y == 0 && z == 0) {
      return fail(Status::invalid_argument,
                  "--clip-plane: expected a normal X,Y,Z that is not 0,0,0, then the offset");
    }
    settings.clip_planes.push_back({{x, y, z}, offset});
  }
  settings.projected = !call.unprojected;
  settings.light = light_settings(call);
  settings.eye_dome = static_cast<float>(call.eye_dome);
  return settings;
}

Camera render_camera(const RenderCall& call, const VolumeGrid& grid, double aspect) {
  if (const auto& c = call.camera; c.size() >= 6) {
    return {{c[3], c[4], c[5]},      c[2], c[0], c[1], c.size() > 6 ? c[6] : 0,
            c.size() > 7 ? c[7] : 30};
  }
  Camera camera = default_camera(grid, aspect);
  const double default_distance = camera.distance * std::sin(camera.field_of_view / 2 / 57.29578);
  camera.azimuth = call.azimuth;
  camera.elevation = call.elevation;
  camera.roll = call.roll;
  camera.field_of_view = call.field_of_view;
  camera.distance = call.distance > 0
                        ? call.distance
                        : default_distance / std::sin(call.field_of_view / 2 / 57.29578);
  camera.distance /= call.zoom;
  if (call.target.size() == 3) camera.target = {call.target[0], call.target[1], call.target[2]};
  return camera;
}

/// The output files, in order.
std::vector<std::filesystem::path> picture_paths(const RenderCall& call) {
  const std::filesystem::path output = call.output;
  if (call.turntable == 0) return {output};
  std::vector<std::filesystem::path> paths;
  for (int frame = 0; frame < call.turntable; ++frame) {
    paths.push_back(output);
    paths.back().replace_filename(
        fmt::format("{}-{:03}{}", output.stem().string(), frame, output.extension().string()));
  }
  return paths;
}

Result<void> check_outputs(const RenderCall& call,
                           std::span<const std::filesystem::path> pictures) {
  const std::array<std::filesystem::path, 1> inputs{call.store};
  for (const std::filesystem::path& picture : pictures) {
    if (auto checked = check_not_input(picture, inputs); !checked) return checked;
    if (auto checked = check_replaceable(picture, "\x89PNG", "a PNG file", call.force); !checked) {
      return checked;
    }
  }
  return {};
}

/// Whether every pixel has the background's colour (not premultiplied).
bool is_only_background(const Image& image, const std::array<float, 4>& background) {
  const uint8_t* const first = image.at(0, 0);
  for (size_t c = 0; c < 4; ++c) {
    const bool matters = c == 3 || first[3] > 0;
    if (matters && std::abs(float(first[c]) - 255 * background[c]) > 2) return false;
  }
  return image.is_uniform();
}

/// Prints a note for each isovalue without an isosurface. If `is_empty` (all pictures are
/// background) although an isosurface exists, prints the possible causes.
void explain_empty_pictures(const StoreInfo& info, std::span<const double> isovalues,
                            bool is_empty) {
  size_t without_surface = 0;
  for (const double isovalue : isovalues) {
    const std::string reason = no_isosurface(info, isovalue);
    if (reason.empty()) continue;
    ++without_surface;
    note(reason);
  }
  if (is_empty && without_surface < isovalues.size()) {
    note(
        "the picture is empty: the isosurface is clipped, transparent, outside of the image, or "
        "of the background's colour");
  }
}

int run(const RenderCall& call) {
  const auto size = parse_pixel_size(call.size);
  if (!size || std::min(size->width, size->height) < 1 ||
      std::max(size->width, size->height) > kMaxPictureSize) {
    return report({Status::invalid_argument,
                   fmt::format("--size: expected WIDTHxHEIGHT in pixels, each 1 to {}, found '{}'",
                               kMaxPictureSize, call.size)});
  }
  const int width = static_cast<int>(size->width), height = static_cast<int>(size->height);
  auto settings = render_settings(call);
  if (!settings) return report(settings.error());
  const auto store = StoreFile::open(call.store);
  if (!store) return report(store.error());
  const auto pictures = picture_paths(call);
  if (auto checked = check_outputs(call, pictures); !checked) return report(checked.error());
  if (settings->colour_by == ColourBy::isovalue && call.colour_range.size() != 2) {
    const StoreInfo& info = (*store)->info();
    settings->colour_low = info.mapping.value(info.range.min);
    settings->colour_high = info.mapping.value(info.range.max);
  }
  const auto context = EglContext::create();
  if (!context) return report(context.error());
  auto renderer = Renderer::create();
  if (!renderer) return report(renderer.error());
  const auto scene = show_store(**renderer, **store, call.isovalues, call.level, call.samples);
  if (!scene) return report(scene.error());
  if (!call.level && scene->level > 0) {
    note(fmt::format("level {} is drawn: finer levels have more than {} samples (see --samples)",
                     scene->level, call.samples));
  }
  (*renderer)->set_settings(*settings);

  Camera camera = render_camera(call, (*store)->info().grid, double(width) / height);
  const size_t frames = pictures.size();
  FrameStatistics statistics;
  bool is_empty = true;
  for (const std::filesystem::path& picture : pictures) {
    (*renderer)->set_camera(camera);
    const auto image = draw_image(**renderer, width, height, &statistics, !call.aliased);
    if (!image) return report(image.error());
    if (const auto written = write_png(picture.string(), *image); !written) {
      return report(written.error());
    }
    is_empty = is_empty && is_only_background(*image, settings->background);
    camera.azimuth += 360.0 / static_cast<double>(frames);
  }
  explain_empty_pictures((*store)->info(), call.isovalues, is_empty);
  fmt::print("{}: {} × {}{}, {} samples of level {}, {}\n", call.output, width, height,
             frames > 1 ? fmt::format(", {} frames", frames) : "",
             with_commas(statistics.samples_drawn), scene->level, (*renderer)->limits().renderer);
  if (settings->shading == Shading::smooth && !(*renderer)->limits().float_targets) {
    note("this OpenGL has no floating-point render targets: shading is exact instead of smooth");
  }
  return kSuccess;
}

void add_output_options(CLI::App* command, RenderCall* call) {
  command->add_option("store", call->store, "A store file")->required();
  command->add_option("-i,--isovalue", call->isovalues, "One or several isovalues: 60.5,180.5")
      ->delimiter(',')
      ->check(is_number())
      ->required();
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
  const LightSettings light;
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
                               kMaxClipPlanes))
      ->delimiter(',')
      ->check(is_number())
      ->expected(1, kMaxClipPlanes);
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

void add_render_command(CLI::App& program, int& exit_code) {
  CLI::App* command =
      program.add_subcommand("render", "Draw isosurfaces of a store into a picture (PNG file)");
  auto call = std::make_shared<RenderCall>();
  add_output_options(command, call.get());
  add_colour_options(command, call.get());
  add_camera_options(command, call.get());
  add_light_options(command, call.get());
  add_scene_options(command, call.get());
  command->footer(examples(
      "  isosplat render engine.isosplat --isovalue 60.5 -o engine.png\n"
      "  isosplat render head.isosplat -i 1150,500 --opacity 1,0.35 --zoom 1.4 -o head.png\n"
      "  isosplat render bunny.isosplat -i 1000 --turntable 36 --background transparent"));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
