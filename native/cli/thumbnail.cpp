#include "native/cli/thumbnail.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>

#include "native/files/output_file.h"
#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "native/headless/scene_picture.h"
#include "native/headless/store_scene.h"
#include "native/scene/layer_surfaces.h"
#include "server/catalog/thumbnail.h"
#include "shared/system/scene_file/bundle_bytes.h"
#include "shared/system/scene_file/scene_file.h"

namespace isosplat::cli {
namespace {

/// Pixels: the size of a card in the page's list, and a third more for screens of high resolution.
constexpr int kWidth = 480, kHeight = 300;

/// Each pixel is the mean of this many pixels along each side. This costs much less than the
/// antialiasing of draw_image(), which a picture of this size does not need.
constexpr int kScale = 2;

/// A level with this many cells along its longest side has enough detail for this picture. Finer
/// levels and more samples would add none.
constexpr int32_t kEnoughCells = 640;
constexpr uint64_t kEnoughSamples = uint64_t{2} << 20;

/// As in the page (web/viewer/surfaces.ts, web/page/catalog/previews.ts).
constexpr Vec3f kBone{0xd9 / 255.0f, 0xcc / 255.0f, 0xb3 / 255.0f};

/// The surface fills this share of the picture's width or height.
constexpr double kFilled = 0.88;

uint32_t enough_level(const StoreInfo& info) {
  uint32_t level = 0;
  for (; level + 1 < info.levels; ++level) {
    const Index3 cells = level_grid(info.grid.voxels, level).cells;
    if (std::max({cells.x, cells.y, cells.z}) <= kEnoughCells) break;
  }
  return level;
}

/// Means of kScale × kScale pixels.
Image reduced(const Image& image) {
  Image small{image.width / kScale, image.height / kScale, {}};
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      std::array<int, 4> sum{};
      for (int i = 0; i < kScale * kScale; ++i) {
        const uint8_t* const pixel = image.at(kScale * x + i % kScale, kScale * y + i / kScale);
        for (size_t c = 0; c < 3; ++c) sum[c] += pixel[c] * pixel[3];
        sum[3] += pixel[3];
      }
      for (size_t c = 0; c < 3; ++c) {
        small.rgba.push_back(static_cast<uint8_t>(sum[3] ? (sum[c] + sum[3] / 2) / sum[3] : 0));
      }
      small.rgba.push_back(static_cast<uint8_t>(sum[3] / (kScale * kScale)));
    }
  }
  return small;
}

/// Moves the camera so that the visible object in its image is centred and fills the picture. Exact
/// for points at the distance of the target.
void frame_visible(const Image& image, render::Camera& camera) {
  int left = image.width, right = -1, top = image.height, bottom = -1;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image.at(x, y)[3] == 0) continue;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  if (right < left) return;
  const render::CameraFrame frame = render::camera_frame(camera);
  const double pixel = 2 * frame.half_height(camera.distance) / image.height;
  camera.target = camera.target +
                  frame.right * (pixel * (0.5 * (left + right + 1) - 0.5 * image.width)) -
                  frame.up * (pixel * (0.5 * (top + bottom + 1) - 0.5 * image.height));
  const double filled =
      std::max(double(right + 1 - left) / image.width, double(bottom + 1 - top) / image.height);
  constexpr double kNearest = 0.1;  // so that a speck of noise does not fill the picture
  camera.distance *= std::max(filled / kFilled, kNearest);
}

/// What a thumbnail shows: its surfaces, and the camera.
struct View {
  render::RenderSettings settings;
  render::Camera camera;
  bool is_framed = false;  ///< the camera is moved so that what is visible fills the picture
};

/// Uploads what a thumbnail of a store or a scene shows.
using Show = std::function<Result<View>(render::Renderer& renderer)>;

Result<View> show(render::Renderer& renderer, const StoreFile& store, double isovalue) {
  const std::array isovalues{isovalue};
  const auto shown = show_store(renderer, store, isovalues, std::nullopt, kEnoughSamples,
                                enough_level(store.info()));
  if (!shown) return tl::unexpected(shown.error());
  View view;
  view.settings.isosurfaces = {{isovalue, kBone, 1}};
  view.camera = render::default_camera(store.info().grid, double(kWidth) / kHeight);
  view.is_framed = true;
  return view;
}

/// The step that a scene shows first, with its surfaces and its camera.
Result<View> show(render::Renderer& renderer, const SceneFile& scene) {
  const size_t step = first_step(scene.scene());
  const auto shown =
      show_scene(renderer, scene, step, std::nullopt, kEnoughSamples, shown_field(scene.scene()));
  if (!shown) return tl::unexpected(shown.error());
  View view;
  view.settings.isosurfaces = shown->isosurfaces;
  apply_scene(scene.scene(), *shown, view.settings);
  const auto& camera = scene.scene().camera;
  view.camera =
      camera ? camera_of(*camera) : render::default_camera(shown->extent, double(kWidth) / kHeight);
  view.is_framed = !camera;
  return view;
}

/// On a transparent background.
Result<Image> draw(const Show& show) {
  const auto context = EglContext::create();
  if (!context) return tl::unexpected(context.error());
  auto renderer = render::Renderer::create();
  if (!renderer) return tl::unexpected(renderer.error());
  auto view = show(**renderer);
  if (!view) return tl::unexpected(view.error());
  auto& [settings, camera, is_framed] = *view;
  settings.kind = render::SplatKind::quad;
  settings.background = {1, 1, 1, 0};
  (*renderer)->set_settings(settings);
  for (int turn = 0; is_framed && turn < 3; ++turn) {  // later turns correct perspective
    (*renderer)->set_camera(camera);
    const auto sketch = draw_image(**renderer, kWidth / 2, kHeight / 2);
    if (!sketch) return tl::unexpected(sketch.error());
    frame_visible(*sketch, camera);
  }
  settings.kind = render::SplatKind::exact;
  (*renderer)->set_settings(settings);
  (*renderer)->set_camera(camera);
  auto image = draw_image(**renderer, kScale * kWidth, kScale * kHeight);
  if (image) *image = reduced(*image);
  return image;
}

/// Draws and writes the thumbnail of a file, unless it has one.
Result<void> draw_thumbnail_of(const std::filesystem::path& file, std::string_view content,
                               const Show& show) {
  const std::filesystem::path path = server::thumbnail_path(file);
  if (server::read_thumbnail(file, content)) return {};
  if (server::thumbnail_content(path).empty() && !first_bytes(path, 1).empty()) {
    return fail(
        Status::invalid_argument,
        fmt::format("{}: expected no file, or a thumbnail, found another file: move it away",
                    path.string()));
  }
  const auto image = draw(show);
  if (!image) return tl::unexpected(image.error());
  if (image->is_uniform()) return fail(Status::not_found, "the picture is empty");
  return write_picture(path, *image, content);
}

}  // namespace

Result<void> write_picture(const std::filesystem::path& path, const Image& image,
                           std::string_view content) {
  const bool is_thumbnail = path.extension() == server::kThumbnailExtension;
  const auto encoded = is_thumbnail ? encode_webp(image) : encode_png(image);
  if (!encoded) return fail(encoded.error().status, path.string() + ": " + encoded.error().message);
  if (!is_thumbnail) return write_whole_file(path, *encoded);
  return write_whole_file(path, server::with_content_id(*encoded, content));
}

bool is_refused_thumbnail(const std::filesystem::path& picture, const std::filesystem::path& file,
                          std::string_view content) {
  std::error_code error;
  const auto real = [&](const std::filesystem::path& path) {
    return std::filesystem::weakly_canonical(path, error);
  };
  return real(picture) == real(server::thumbnail_path(file)) &&
         !server::read_thumbnail(file, content);
}

Result<Image> picture_of_isovalue(const StoreFile& store, double isovalue) {
  return draw([&](render::Renderer& renderer) { return show(renderer, store, isovalue); });
}

Result<void> draw_thumbnail(const std::filesystem::path& store) {
  const auto opened = StoreFile::open(store);
  if (!opened) return tl::unexpected(opened.error());
  return draw_thumbnail_of(
      store, (*opened)->content(), [&](render::Renderer& renderer) -> Result<View> {
        const auto isovalue = suggested_isovalue((*opened)->info());
        if (!isovalue) return fail(Status::not_found, "the volume has no suggested isovalue");
        return show(renderer, **opened, *isovalue);
      });
}

Result<void> draw_scene_thumbnail(const std::filesystem::path& scene) {
  const auto opened = SceneFile::open(scene);
  if (!opened) return tl::unexpected(opened.error());
  const auto bundle = BundleBytes::plan(*opened);
  if (!bundle) return tl::unexpected(bundle.error());
  return draw_thumbnail_of(scene, bundle->content(),
                           [&](render::Renderer& renderer) { return show(renderer, *opened); });
}

}  // namespace isosplat::cli
