#include "native/headless/image.h"

#include <png.h>
#include <webp/encode.h>

#include <algorithm>
#include <memory>

#include "native/files/output_file.h"

namespace isosplat {

bool Image::is_uniform() const {
  return std::equal(rgba.begin() + std::min<std::ptrdiff_t>(4, std::ssize(rgba)), rgba.end(),
                    rgba.begin());
}

Result<std::vector<std::byte>> encode_png(const Image& image) {
  bool opaque = true;
  for (size_t i = 3; i < image.rgba.size(); i += 4) opaque = opaque && image.rgba[i] == 255;
  std::vector<uint8_t> rgb;
  if (opaque) {
    rgb.reserve(image.rgba.size() / 4 * 3);
    for (size_t i = 0; i < image.rgba.size(); i += 4) {
      rgb.insert(rgb.end(), &image.rgba[i], &image.rgba[i] + 3);
    }
  }
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = opaque ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  std::vector<std::byte> bytes(PNG_IMAGE_PNG_SIZE_MAX(png));
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0,
                                 opaque ? rgb.data() : image.rgba.data(), 0, nullptr)) {
    return fail(Status::io_error, std::string("cannot write a picture (") + png.message + ")");
  }
  bytes.resize(size);
  return bytes;
}

Result<std::vector<std::byte>> encode_webp(const Image& image) {
  constexpr float kQuality = 80;  // of 100
  uint8_t* encoded = nullptr;
  const size_t size = WebPEncodeRGBA(image.rgba.data(), image.width, image.height, 4 * image.width,
                                     kQuality, &encoded);
  const std::unique_ptr<uint8_t, decltype(&WebPFree)> owned(encoded, WebPFree);
  if (size == 0) {
    return fail(Status::io_error, "cannot write a picture (WebP: at most 16383 × 16383 pixels)");
  }
  const auto* const begin = reinterpret_cast<const std::byte*>(encoded);
  return std::vector<std::byte>(begin, begin + size);
}

Result<void> write_png(const std::string& path, const Image& image) {
  const auto png = encode_png(image);
  if (!png) return fail(png.error().status, path + ": " + png.error().message);
  return write_whole_file(path, *png);
}

Result<Image> read_png(const std::string& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&png, path.c_str())) {
    return fail(Status::io_error, path + ": cannot read the picture (" + png.message + ")");
  }
  png.format = PNG_FORMAT_RGBA;
  Image image{static_cast<int>(png.width), static_cast<int>(png.height), {}};
  image.rgba.resize(PNG_IMAGE_SIZE(png));
  if (!png_image_finish_read(&png, nullptr, image.rgba.data(), 0, nullptr)) {
    return fail(Status::io_error, path + ": cannot read the picture (" + png.message + ")");
  }
  return image;
}

}  // namespace isosplat
