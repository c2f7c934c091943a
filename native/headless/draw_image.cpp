#include "native/headless/draw_image.h"

#include <algorithm>

#include "native/headless/offscreen_target.h"
#include "shared/render/frame/image_tile.h"
#include "shared/render/gl/pixel_reader.h"

namespace isosplat {
namespace {

/// Larger images are drawn in tiles of this size, px: a tile takes about 0.4 GB of GPU memory.
constexpr int kTile = 2048;

Image image_of_size(int width, int height) {
  return {width, height, std::vector<uint8_t>(4 * size_t(width) * size_t(height))};
}

Result<render::FrameStatistics> draw_whole(render::Renderer& renderer, bool smooth, Image& image) {
  const OffscreenTarget target(image.width, image.height);
  const auto drawn = smooth ? renderer.draw_still(image.width, image.height, target.framebuffer())
                            : renderer.draw(image.width, image.height, target.framebuffer());
  if (!drawn) return drawn;
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
  render::read_straight_pixels(0, 0, image.width, image.height, image.rgba);
  return drawn;
}

/// Copies a tile to its place, from its upper left corner.
void copy_tile(const Image& tile, int left, int top, Image& image) {
  const size_t row = 4 * size_t(tile.width);
  for (int y = 0; y < tile.height; ++y) {
    const size_t to = 4 * (size_t(top + y) * size_t(image.width) + size_t(left));
    std::copy_n(tile.at(0, y), row, &image.rgba[to]);
  }
}

Result<render::FrameStatistics> draw_in_tiles(render::Renderer& renderer, bool smooth,
                                              Image& image) {
  if (auto ok = renderer.begin_tiles(image.width, image.height); !ok) {
    return tl::unexpected(ok.error());
  }
  render::FrameStatistics sum;
  Result<render::FrameStatistics> drawn = sum;
  for (int top = 0; drawn && top < image.height; top += kTile) {
    for (int left = 0; drawn && left < image.width; left += kTile) {
      Image tile =
          image_of_size(std::min(kTile, image.width - left), std::min(kTile, image.height - top));
      drawn = renderer.draw_tile(left, top, tile.width, tile.height,
                                 smooth ? render::kStillPictures : 1, tile.rgba);
      if (!drawn) break;
      copy_tile(tile, left, top, image);
      sum.samples_drawn += drawn->samples_drawn;
      sum.draw_calls += drawn->draw_calls;
    }
  }
  renderer.end_tiles();
  return drawn ? sum : drawn;
}

}  // namespace

Result<Image> draw_image(render::Renderer& renderer, int width, int height,
                         render::FrameStatistics* statistics, bool smooth) {
  if (width < 1 || height < 1 || width > render::kMaxImageSize || height > render::kMaxImageSize) {
    return tl::unexpected(renderer.draw(width, height).error());
  }
  // Buffers without memory must not be drawn.
  if (const auto checked = renderer.check_gpu(); !checked) return tl::unexpected(checked.error());
  Image image = image_of_size(width, height);
  auto drawn = std::max(width, height) > 2 * kTile ? draw_in_tiles(renderer, smooth, image)
                                                   : draw_whole(renderer, smooth, image);
  if (const auto checked = renderer.check_gpu(); drawn && !checked) {
    drawn = tl::unexpected(checked.error());
  }
  if (!drawn) return tl::unexpected(drawn.error());
  if (statistics) *statistics = *drawn;
  return image;
}

}  // namespace isosplat
