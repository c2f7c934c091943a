#include <algorithm>

#include "shared/import/images/file.h"

// The headers of JPEG (ISO/IEC 10918-1, annex B) and JPEG 2000 (ISO/IEC 15444-1, annexes A and I).
namespace isosplat::import {
namespace {

/// Big-endian numbers of a file; 0 after its end.
struct Bytes {
  std::span<const uint8_t> file;

  uint64_t number(size_t at, size_t count) const {
    uint64_t value = 0;
    for (size_t i = 0; i < count; ++i)
      value = value << 8 | (at + i < file.size() ? file[at + i] : 0);
    return value;
  }
};

/// The offset of the codestream, after the boxes before it. Nothing if there is none.
std::optional<size_t> codestream_of(const Bytes& bytes) {
  if (bytes.number(0, 4) == 0xff4fff51) return 0;
  constexpr uint64_t kCodestream = 0x6a703263;  // "jp2c"
  for (size_t at = 0; at + 8 <= bytes.file.size();) {
    uint64_t size = bytes.number(at, 4);
    const size_t header = size == 1 ? 16 : 8;
    if (size == 1) size = bytes.number(at + 8, 8);
    if (bytes.number(at + 4, 4) == kCodestream) return at + header;
    if (size < header || size > bytes.file.size() - at) return std::nullopt;
    at += static_cast<size_t>(size);
  }
  return std::nullopt;
}

}  // namespace

std::optional<ImageInfo> jpeg_info(std::span<const uint8_t> file) {
  const Bytes bytes{file};
  ImageInfo info;
  info.format = "JPEG";
  for (size_t at = 2; at + 4 <= file.size();) {
    if (file[at] != 0xff) return std::nullopt;
    const uint8_t marker = file[at + 1];
    if (marker == 0xff) {
      ++at;  // a fill byte
      continue;
    }
    const auto size = static_cast<size_t>(bytes.number(at + 2, 2));
    if (size < 2 || size > file.size() - at - 2) return std::nullopt;
    if (marker == 0xe0 && size >= 14 && bytes.number(at + 4, 4) == 0x4a464946) {  // "JFIF"
      const uint8_t unit = file[at + 11];
      const double per_metre = unit == 1 ? 1 / 0.0254 : unit == 2 ? 100 : 0;
      if (per_metre > 0) {
        info.density_x = per_metre * static_cast<double>(bytes.number(at + 12, 2));
        info.density_y = per_metre * static_cast<double>(bytes.number(at + 14, 2));
      }
    }
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame && size >= 8) {
      info.bits = file[at + 4];
      info.height = static_cast<int64_t>(bytes.number(at + 5, 2));
      info.width = static_cast<int64_t>(bytes.number(at + 7, 2));
      info.channels = file[at + 9];
      if (info.height == 0 || info.width == 0 || info.channels == 0) return std::nullopt;
      return info;
    }
    at += 2 + size;
  }
  return std::nullopt;
}

std::optional<ImageInfo> jpeg2000_info(std::span<const uint8_t> file) {
  const Bytes bytes{file};
  const auto start = codestream_of(bytes);
  // The markers SOC and SIZ and the length of SIZ; the sizes follow.
  if (!start || bytes.number(*start, 4) != 0xff4fff51 || file.size() < *start + 43) {
    return std::nullopt;
  }
  const size_t at = *start;
  ImageInfo info;
  info.format = "JPEG 2000";
  info.width = static_cast<int64_t>(bytes.number(at + 8, 4) - bytes.number(at + 16, 4));
  info.height = static_cast<int64_t>(bytes.number(at + 12, 4) - bytes.number(at + 20, 4));
  info.channels = static_cast<int>(bytes.number(at + 40, 2));
  info.bits = (file[at + 42] & 127) + 1;
  info.is_signed = (file[at + 42] & 128) != 0;
  if (info.width <= 0 || info.height <= 0 || info.channels == 0) return std::nullopt;
  return info;
}

}  // namespace isosplat::import
