#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/outputs.h"
#include "native/cli/render_options.h"
#include "native/cli/render_settings.h"
#include "native/cli/terminal.h"
#include "native/cli/thumbnail.h"
#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "native/headless/scene_picture.h"
#include "native/headless/show_categories.h"
#include "native/headless/store_scene.h"
#include "native/remote/remote_target.h"
#include "server/catalog/thumbnail.h"
#include "shared/system/scene_file/bundle_bytes.h"
#include "shared/system/store_file/field_file.h"

namespace isosplat::cli {
namespace {

constexpr unsigned kReadsAhead = 8;         // of a store at an address
constexpr int64_t kMaxPictureSize = 16384;  // of each side: the usual limit of OpenGL

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
    const bool is_webp = picture.extension() == server::kThumbnailExtension;
    auto checked = is_webp ? check_replaceable(picture, "RIFF", "a WebP file", call.force)
                           : check_replaceable(picture, "\x89PNG", "a PNG file", call.force);
    if (!checked) return checked;
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
        "has the colour of the background");
  }
}

/// What is drawn: a store, or a scene.
struct Subject {
  std::shared_ptr<StoreFile> store;
  std::shared_ptr<StoreFile> field;  // of the store, that colours show; null: none
  std::optional<SceneFile> scene;
};

Result<Subject> open_subject(const RenderCall& call) {
  Subject subject;
  if (scene_kind(call.store, call.remote_flags) == SceneKind::none) {
    auto store = open_store(call.store, call.remote_flags);
    if (!store) return tl::unexpected(store.error());
    subject.store = std::move(*store);
    if (call.field.empty()) return subject;
    const auto index = find_field(subject.store->info(), call.field);
    if (!index) {
      return fail(index.error().status, call.store + ": " + index.error().message);
    }
    auto field = open_field(*subject.store, *index);
    if (!field) return tl::unexpected(field.error());
    subject.field = std::move(*field);
    return subject;
  }
  auto scene = open_scene(call.store, call.remote_flags);
  if (!scene) return tl::unexpected(scene.error());
  subject.scene = std::move(*scene);
  return subject;
}

/// The content id that its thumbnail names. Empty if a scene cannot be served, so that its picture
/// is no thumbnail.
std::string content_of(const Subject& subject) {
  if (subject.store) return subject.store->content();
  const auto bundle = BundleBytes::plan(*subject.scene);
  return bundle ? bundle->content() : std::string();
}

/// Sets the ends of the colour map for a field: those of the option, or else `found`. Prints
/// them.
Result<void> set_field_range(const RenderCall& call, const std::array<double, 2>& found,
                             render::RenderSettings& settings) {
  if (call.field_range.size() == 2) {
    settings.colour_low = call.field_range[0];
    settings.colour_high = call.field_range[1];
  } else {
    settings.colour_low = found[0];
    settings.colour_high = found[1];
  }
  const bool is_logarithmic = settings.field_scale == render::FieldScale::logarithmic;
  if (is_logarithmic && call.field_range.size() == 2 &&
      !(std::min(settings.colour_low, settings.colour_high) > 0)) {
    return fail(Status::invalid_argument,
                fmt::format("--field-range: expected values above 0 for a logarithmic scale, found "
                            "{:g},{:g}",
                            settings.colour_low, settings.colour_high));
  }
  const auto [low, high] = render::field_range(settings);
  fmt::print("field {}: colours from {:g} to {:g}\n", call.field, low, high);
  return {};
}

/// Sets the colours of categories, and prints their number. False if there are none.
bool set_categories(const RenderCall& call, std::span<const Category> categories,
                    render::RenderSettings& settings) {
  show_categories(categories, settings);
  if (categories.empty()) return false;
  fmt::print("field {}: {} categories\n", call.field, categories.size());
  return true;
}

/// `names`: of the fields that visible layers of the scene have.
tl::unexpected<Error> no_such_field(const RenderCall& call, std::span<const std::string> names) {
  return fail(
      Status::not_found,
      fmt::format("{}: field '{}': expected a {}", call.store, call.field,
                  names.empty() ? "visible layer with fields, found none: isosplat build --field "
                                  "adds them to stores"
                                : fmt::format("field of a visible layer, which have {}",
                                              fmt::join(names, ", "))));
}

struct Shown {
  uint32_t level = 0;  ///< the coarsest that is drawn
  VolumeGrid extent;
};

/// Uploads what the picture needs. Of a scene, sets its surfaces, clipping, slices, look and
/// background.
Result<Shown> show_subject(render::Renderer& renderer, const Subject& subject,
                           const RenderCall& call, render::RenderSettings& settings) {
  if (subject.store) {
    VolumePlace place;
    place.field = subject.field.get();
    const auto shown =
        show_store(renderer, *subject.store, call.isovalues, call.level, call.samples, 0, place,
                   remote::is_address(call.store) ? kReadsAhead : 0);
    if (!shown) return tl::unexpected(shown.error());
    if (subject.field) {
      const FieldInfo& field = *subject.field->info().field;
      if (set_categories(call, categories_of(subject.field->info().metadata), settings)) {
        return Shown{shown->level, subject.store->info().grid};
      }
      const std::array all{field.mapping.value(field.range.min),
                           field.mapping.value(field.range.max)};
      const auto set = set_field_range(call, shown->field_range.value_or(all), settings);
      if (!set) return tl::unexpected(set.error());
    }
    return Shown{shown->level, subject.store->info().grid};
  }
  const size_t step = call.step.value_or(first_step(subject.scene->scene()));
  const Scene& scene = subject.scene->scene();
  std::string field = call.field;
  if (field.empty() && !call.given.contains("--colour-by")) {
    field = shown_field(scene);
    if (!field.empty() && call.given.contains("--range")) {
      return fail(Status::invalid_argument,
                  fmt::format("--range: the scene shows the field '{0}', whose values --field {0} "
                              "--field-range LOW,HIGH states",
                              field));
    }
  }
  const auto shown = show_scene(renderer, *subject.scene, step, call.level, call.samples, field);
  if (!shown) return tl::unexpected(shown.error());
  if (!call.field.empty() && !shown->field_range) return no_such_field(call, shown->fields);
  for (const std::string& text : shown->notes) note(text);
  settings.isosurfaces = shown->isosurfaces;
  apply_scene_settings(call, scene, *shown, settings);
  if (!call.field.empty() && !set_categories(call, shown->categories, settings)) {
    const auto set = set_field_range(call, *shown->field_range, settings);
    if (!set) return tl::unexpected(set.error());
  }
  return Shown{shown->coarsest, shown->extent};
}

/// Checks that the options fit a store or a scene. Throws the errors of CLI11 for wrong arguments.
void check_arguments(const RenderCall& call) {
  const bool is_scene = scene_kind(call.store, call.remote_flags) != SceneKind::none;
  if (!is_scene && call.isovalues.empty()) throw CLI::RequiredError("--isovalue");
  if (is_scene && !(call.isovalues.empty() && call.colours.empty() && call.opacities.empty())) {
    throw CLI::ExcludesError("a scene, which states its surfaces,",
                             "--isovalue, --colour and --opacity");
  }
  if (!call.field.empty() && !call.colour_range.empty()) {
    throw CLI::ExcludesError("--field", "--range: --field-range states the values of the field");
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
  const auto subject = open_subject(call);
  if (!subject) return report(subject.error());
  const StoreFile* const store = subject->store.get();
  const auto pictures = picture_paths(call);
  if (auto checked = check_outputs(call, pictures); !checked) return report(checked.error());
  if (store && settings->colour_by == render::ColourBy::isovalue && call.colour_range.size() != 2) {
    const StoreInfo& info = store->info();
    settings->colour_low = info.mapping.value(info.range.min);
    settings->colour_high = info.mapping.value(info.range.max);
  }
  const auto context = EglContext::create();
  if (!context) return report(context.error());
  auto renderer = render::Renderer::create();
  if (!renderer) return report(renderer.error());
  const auto shown = show_subject(**renderer, *subject, call, *settings);
  if (!shown) return report(shown.error());
  if (!call.level && shown->level > 0) {
    note(fmt::format("level {} is drawn: finer levels have more than {} samples (see --samples)",
                     shown->level, call.samples));
  }
  (*renderer)->set_settings(*settings);

  render::Camera camera = render_camera(call, shown->extent, double(width) / height);
  if (subject->scene && subject->scene->scene().camera && call.camera.empty()) {
    camera = camera_of(*subject->scene->scene().camera);
  }
  const std::string content = content_of(*subject);
  const size_t frames = pictures.size();
  render::FrameStatistics statistics;
  bool is_empty = true;
  for (const std::filesystem::path& picture : pictures) {
    (*renderer)->set_camera(camera);
    const auto image = draw_image(**renderer, width, height, &statistics, !call.aliased);
    if (!image) return report(image.error());
    const auto written = write_picture(picture, *image, content);
    if (!written) return report(written.error());
    if (!content.empty() && is_refused_thumbnail(picture, call.store, content)) {
      note(
          fmt::format("{} is too large for a thumbnail: expected at most {} × {} "
                      "pixels and 1 MiB (see --size)",
                      picture.string(), server::kMaxThumbnailSize, server::kMaxThumbnailSize));
    }
    is_empty = is_empty && is_only_background(*image, settings->background);
    camera.azimuth += 360.0 / static_cast<double>(frames);
  }
  if (store) explain_empty_pictures(store->info(), call.isovalues, is_empty);
  fmt::print("{}: {} × {}{}, {} samples of level {}, {}\n", call.output, width, height,
             frames > 1 ? fmt::format(", {} frames", frames) : "",
             with_commas(statistics.samples_drawn), shown->level, (*renderer)->limits().renderer);
  if (settings->shading == render::Shading::smooth && !(*renderer)->limits().float_targets) {
    note("this OpenGL has no floating-point render targets: shading is exact instead of smooth");
  }
  return kSuccess;
}

}  // namespace

void add_render_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "render", "Draw isosurfaces of a store or a scene into a picture (PNG or WebP file)");
  auto call = std::make_shared<RenderCall>();
  add_render_options(command, call.get());
  command->footer(examples(
      "  isosplat render engine.isosplat --isovalue 60.5 -o engine.png\n"
      "  isosplat render head.isosplat -i 1150,500 --opacity 1,0.35 --zoom 1.4 -o head.png\n"
      "  isosplat render flow.isosplat -i 0.4 --field pressure --colour-map turbo -o flow.png\n"
      "  isosplat render bunny.isosplat -i 1000 --turntable 36 --background transparent\n"
      "  isosplat render scene.json -o scene.png\n"
      "  isosplat render head.isosplat -i 1150 --size 480x300 -o head.isosplat.webp\n"
      "  isosplat render head.isobundle --size 480x300 -o head.isobundle.webp\n"
      "The last two commands draw thumbnails for the lists of the page: FILE.webp beside the "
      "store\n"
      "or the scene, of at most 1 MiB. They replace the thumbnail that isosplat build has drawn."));
  command->callback([call, command, &exit_code] {
    for (const CLI::Option* option : command->get_options()) {
      if (option->count() > 0) call->given.insert(option->get_name());
    }
    check_arguments(*call);
    exit_code = run(*call);
  });
}

}  // namespace isosplat::cli
