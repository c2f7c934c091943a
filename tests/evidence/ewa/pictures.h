#pragma once

#include <span>

#include "native/headless/image.h"
#include "tests/evidence/ewa/ewa_filter.h"
#include "tests/evidence/ewa/signal.h"

namespace isosplat {

/// The picture over black, sRGB.
Image over_black(const EwaPicture& picture);

/// The luminance of a picture, decoded from sRGB.
Luminance decoded(const Image& image);

/// A grey picture of luminances.
Image encoded(const Luminance& luminance);

/// A part of a picture, each pixel as `zoom` × `zoom`.
Image cropped(const Image& image, int left, int top, int width, int height, int zoom);

}  // namespace isosplat
