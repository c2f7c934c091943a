#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "shared/core/base/status.h"

namespace isosplat {

/// An RGBA picture, 8 bits each, sRGB, alpha not premultiplied, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;

  /// Whether all pixels are equal.
  bool is_uniform() const;

  const uint8_t* at(int x, int y) const {
    return &rgba[4 * (size_t(y) * size_t(width) + size_t(x))];
  }
};

/// A PNG: RGB if all pixels are opaque, otherwise RGBA. Errors: io_error.
Result<std::vector<std::byte>> encode_png(const Image& image);

/// A WebP file, lossy: for small pictures of lists. Errors: io_error.
Result<std::vector<std::byte>> encode_webp(const Image& image);

/// Writes a PNG file: RGB if all pixels are opaque, otherwise RGBA. Errors: io_error, and those of
/// OutputFile.
Result<void> write_png(const std::string& path, const Image& image);

/// Reads a PNG with 8 bits per channel, of any colour type. Errors: io_error.
Result<Image> read_png(const std::string& path);

}  // namespace isosplat
