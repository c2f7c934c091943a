#include "shared/render/frame/image_tile.h"

#include <algorithm>
#include <cmath>

namespace isosplat::render {

ImageTile with_margin(const ImageTile& tile, int margin) {
  const int left = std::max(tile.left - margin, 0), bottom = std::max(tile.bottom - margin, 0);
  return {std::min(tile.left + tile.width + margin, tile.image_width) - left,
          std::min(tile.bottom + tile.height + margin, tile.image_height) - bottom,
          tile.image_width,
          tile.image_height,
          left,
          bottom};
}

ImageTile reduced_image(const ImageTile& tile, int most) {
  const double scale = std::min(1.0, double(most) / std::max(tile.image_width, tile.image_height));
  const auto reduced = [scale](int px) { return std::max(1, int(std::lround(scale * px))); };
  return {reduced(tile.image_width), reduced(tile.image_height)};
}

}  // namespace isosplat::render
