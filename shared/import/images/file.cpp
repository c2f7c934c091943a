#include "shared/import/images/file.h"

#include <fmt/format.h>

#include "shared/import/bytes/readable_file.h"

namespace isosplat::import {
namespace {

using namespace std::string_view_literals;

/// Larger files are not slices.
constexpr uint64_t kMaxFile = uint64_t{1} << 30;

/// The first `limit` bytes of a file.
Result<std::vector<uint8_t>> bytes_of(const std::filesystem::path& path, uint64_t limit) {
  const auto file = ReadableFile::open(path);
  if (!file) return tl::unexpected(file.error());
  if (limit == kMaxFile && file->size > limit) {
    return fail(Status::volume_too_large,
                fmt::format("{}: expected a picture of at most 1 GiB, found {} bytes: save the "
                            "volume in another format",
                            path.string(), file->size));
  }
  std::vector<uint8_t> bytes(static_cast<size_t>(std::min(file->size, limit)));
  const auto got = file->input->read_some(0, std::as_writable_bytes(std::span(bytes)));
  if (!got) return tl::unexpected(got.error());
  bytes.resize(*got);
  return bytes;
}

std::optional<ImageInfo> info_of(std::span<const uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string_view format = image_format_of(text);
  if (format == "PNG") return png_info(bytes);
  if (format == "JPEG") return jpeg_info(bytes);
  if (format == "JPEG 2000") return jpeg2000_info(bytes);
  return std::nullopt;
}

}  // namespace

std::string_view image_format_of(std::string_view beginning) {
  if (beginning.starts_with("\x89PNG\r\n\x1a\n"sv)) return "PNG";
  if (beginning.starts_with("\xff\xd8\xff"sv)) return "JPEG";
  if (beginning.starts_with("\0\0\0\x0cjP  \r\n\x87\n"sv) ||
      beginning.starts_with("\xff\x4f\xff\x51"sv)) {
    return "JPEG 2000";
  }
  return {};
}

Result<ImageInfo> read_image_info(const std::filesystem::path& path) {
  // Metadata before the sizes may be longer than the first bytes.
  for (const uint64_t limit : {uint64_t{64} << 10, kMaxFile}) {
    const auto bytes = bytes_of(path, limit);
    if (!bytes) return tl::unexpected(bytes.error());
    if (const auto info = info_of(*bytes)) return *info;
    if (bytes->size() < limit) break;
  }
  return damaged_image(path);
}

Result<void> decode_image(const std::filesystem::path& path, const ImageInfo& info,
                          [[maybe_unused]] uint64_t memory_bytes, std::span<std::byte> out) {
  if (info.format == "PNG") {
    const auto bytes = bytes_of(path, kMaxFile);
    if (!bytes) return tl::unexpected(bytes.error());
    if (!decode_png(*bytes, info, out)) return damaged_image(path);
    return {};
  }
#ifdef __EMSCRIPTEN__
  return fail(Status::unsupported_format,
              fmt::format("{}: the browser does not decode {} to exact samples: build the store "
                          "with the program (isosplat build), and open that",
                          path.string(), info.format));
#else
  const auto bytes = bytes_of(path, kMaxFile);
  if (!bytes) return tl::unexpected(bytes.error());
  return decode_with_library(path, *bytes, info, memory_bytes, out);
#endif
}

tl::unexpected<Error> damaged_image(const std::filesystem::path& path) {
  return fail(Status::malformed_volume,
              fmt::format("{}: expected a whole picture (PNG, JPEG or JPEG 2000), found damaged or "
                          "incomplete data: copy or download it again",
                          path.string()));
}

}  // namespace isosplat::import
