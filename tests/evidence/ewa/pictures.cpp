#include "tests/evidence/ewa/pictures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/render/settings/light.h"

namespace isosplat {
namespace {

uint8_t encoded_channel(double linear) {
  const float srgb = render::linear_to_srgb(static_cast<float>(std::clamp(linear, 0.0, 1.0)));
  return static_cast<uint8_t>(std::lround(255 * srgb));
}

Image image_of(int width, int height) {
  return {width, height, std::vector<uint8_t>(4 * size_t(width) * size_t(height), 255)};
}

}  // namespace

Image over_black(const EwaPicture& picture) {
  Image image = image_of(picture.width, picture.height);
  for (size_t i = 0; i < picture.colour.size(); ++i) {
    const double coverage = picture.coverage[i];
    const Vec3f c = picture.colour[i];
    image.rgba[4 * i] = encoded_channel(coverage * double(c.x));
    image.rgba[4 * i + 1] = encoded_channel(coverage * double(c.y));
    image.rgba[4 * i + 2] = encoded_channel(coverage * double(c.z));
  }
  return image;
}

Luminance decoded(const Image& image) {
  std::array<float, 256> linear{};
  for (size_t i = 0; i < linear.size(); ++i) linear[i] = render::srgb_to_linear(float(i) / 255);
  Luminance luminance{image.width, image.height, {}};
  luminance.value.resize(size_t(image.width) * size_t(image.height));
  for (size_t i = 0; i < luminance.value.size(); ++i) {
    const uint8_t* p = &image.rgba[4 * i];
    luminance.value[i] = luminance_of({linear[p[0]], linear[p[1]], linear[p[2]]});
  }
  return luminance;
}

Image encoded(const Luminance& luminance) {
  Image image = image_of(luminance.width, luminance.height);
  for (size_t i = 0; i < luminance.value.size(); ++i) {
    std::fill_n(&image.rgba[4 * i], 3, encoded_channel(luminance.value[i]));
  }
  return image;
}

Image cropped(const Image& image, int left, int top, int width, int height, int zoom) {
  Image part = image_of(width * zoom, height * zoom);
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      std::copy_n(image.at(left + x / zoom, top + y / zoom), 4,
                  &part.rgba[4 * (size_t(y) * size_t(part.width) + size_t(x))]);
    }
  }
  return part;
}

}  // namespace isosplat
