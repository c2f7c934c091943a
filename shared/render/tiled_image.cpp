#include <string>

#include "shared/render/gl/pixel_reader.h"
#include "shared/render/renderer_state.h"

/// Pictures in tiles. A tile is drawn with a margin, since edge shading and occlusion read the
/// depths around a pixel. Depths farther away are read from a picture of the whole image at low
/// resolution.
namespace isosplat::render {

static_assert(kStillPictures == Accumulation::kPictures);
namespace {

/// Largest width and height of this picture of the whole image, px.
constexpr int kMostOfWholeImage = 1024;

}  // namespace

Result<void> Renderer::begin_tiles(int width, int height) {
  if (state_->lost) return fail(Status::gl_error, "the GL context is lost");
  if (width < 1 || height < 1 || width > kMaxImageSize || height > kMaxImageSize) {
    return fail(Status::invalid_argument,
                "a picture of " + std::to_string(width) + " × " + std::to_string(height) +
                    " pixels is not possible: 1 to " + std::to_string(kMaxImageSize));
  }
  return state_->begin_tiles(width, height);
}

Result<FrameStatistics> Renderer::draw_tile(int x, int y, int width, int height, int pictures,
                                            std::span<uint8_t> rgba) {
  State& s = *state_;
  if (s.lost) return fail(Status::gl_error, "the GL context is lost");
  const auto [image_width, image_height] = std::pair{s.tiled_image.width, s.tiled_image.height};
  if (x < 0 || y < 0 || width < 1 || height < 1 || width > image_width - x ||
      height > image_height - y || rgba.size() != 4 * size_t(width) * size_t(height)) {
    return fail(Status::invalid_argument,
                "expected a part of the " + std::to_string(image_width) + " × " +
                    std::to_string(image_height) + " pixels of begin_tiles, found " +
                    std::to_string(width) + " × " + std::to_string(height) + " from " +
                    std::to_string(x) + ", " + std::to_string(y) + " in " +
                    std::to_string(rgba.size()) + " bytes");
  }
  const ImageTile part{width, height, image_width, image_height, x, image_height - y - height};
  return s.draw_tile(part, pictures, rgba);
}

void Renderer::end_tiles() {
  state_->end_tiles();
}

Result<void> Renderer::State::begin_tiles(int width, int height) {
  tiled_image = {width, height};
  dirty = true;
  if (!Lighting::has_occlusion(settings.light)) return {};
  const ImageTile reduced = reduced_image(tiled_image, kMostOfWholeImage);
  if (auto ok = draw_surfaces(reduced, {}, /*light_directly=*/false); !ok) return ok;
  if (auto ok = draw_caps_and_slices(); !ok) return ok;
  whole_image.swap(shown_context().targets);
  return {};
}

Result<FrameStatistics> Renderer::State::draw_tile(const ImageTile& part, int pictures,
                                                   std::span<uint8_t> rgba) {
  const ImageTile outer = with_margin(part, kTileMargin);
  if (auto ok = tile_picture.prepare(outer.width, outer.height); !ok) {
    return tl::unexpected(ok.error());
  }
  const GLuint framebuffer = tile_picture.framebuffer();
  auto done = draw(outer, framebuffer);
  const bool refines = pictures > 1 && limits.offered.float_targets && mesh.is_empty();
  while (done && refines && accumulation.pictures() < std::min(pictures, kStillPictures)) {
    done = refine(framebuffer);
  }
  dirty = true;
  if (!done) return done;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  read_straight_pixels(part.left - outer.left, part.bottom - outer.bottom, part.width, part.height,
                       rgba);
  return done;
}

void Renderer::State::end_tiles() {
  tiled_image = {};
  dirty = true;
  if (lost) return;
  targets.release();
  caps.release();
  whole_image.release();
  tile_picture.release();
  accumulation.release();
}

}  // namespace isosplat::render
