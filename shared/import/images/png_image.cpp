#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>

#include "shared/import/codecs/checksums.h"
#include "shared/import/codecs/zlib_inflater.h"
#include "shared/import/images/file.h"

// PNG (ISO/IEC 15948). The program and the browser use the same decoder, since the browser's
// built-in one returns only 8 bits.
namespace isosplat::import {
namespace {

constexpr size_t kSignature = 8;

uint32_t number_at(std::span<const uint8_t> bytes, size_t at) {
  return uint32_t{bytes[at]} << 24 | uint32_t{bytes[at + 1]} << 16 | uint32_t{bytes[at + 2]} << 8 |
         bytes[at + 3];
}

struct Chunk {
  std::string_view name;
  std::span<const uint8_t> data;
};

/// The chunk at an offset; advances the offset to the next one. Nothing if it is truncated or
/// damaged.
std::optional<Chunk> next_chunk(std::span<const uint8_t> file, size_t& at) {
  if (file.size() < 12 || at > file.size() - 12) return std::nullopt;
  const size_t size = number_at(file, at);
  if (size > file.size() - 12 - at) return std::nullopt;
  const auto named = file.subspan(at + 4, size + 4);
  if (crc32(0, named) != number_at(file, at + 8 + size)) return std::nullopt;
  at += 12 + size;
  return Chunk{{reinterpret_cast<const char*>(named.data()), 4}, named.subspan(4)};
}

/// A part of a picture with separate rows: the whole picture, or one of the seven passes of Adam7.
struct Pass {
  int64_t x0, y0, dx, dy;
  int64_t columns(int64_t width) const { return width > x0 ? (width - x0 + dx - 1) / dx : 0; }
  int64_t rows(int64_t height) const { return height > y0 ? (height - y0 + dy - 1) / dy : 0; }
};

constexpr Pass kWhole[] = {{0, 0, 1, 1}};
constexpr Pass kAdam7[] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                           {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};

std::span<const Pass> passes_of(const ImageInfo& info) {
  return info.is_interlaced ? std::span<const Pass>(kAdam7) : std::span<const Pass>(kWhole);
}

size_t row_bytes(const ImageInfo& info, int64_t columns) {
  return (static_cast<size_t>(columns) * static_cast<size_t>(info.bits) + 7) / 8;
}

uint8_t paeth(int left, int above, int corner) {
  const int guess = left + above - corner;
  const int a = std::abs(guess - left), b = std::abs(guess - above), c = std::abs(guess - corner);
  return static_cast<uint8_t>(a <= b && a <= c ? left : b <= c ? above : corner);
}

/// Reverses a row's filter. `above`: the previous row, unfiltered. Returns false for an unknown
/// filter.
bool unfilter(int filter, size_t step, std::span<const uint8_t> above, std::span<uint8_t> row) {
  if (filter > 4) return false;
  for (size_t i = 0; i < row.size(); ++i) {
    const int left = i >= step ? row[i - step] : 0, up = above[i];
    const int corner = i >= step ? above[i - step] : 0;
    const int guess = filter == 0   ? 0
                      : filter == 1 ? left
                      : filter == 2 ? up
                      : filter == 3 ? (left + up) / 2
                                    : paeth(left, up, corner);
    row[i] = static_cast<uint8_t>(row[i] + guess);
  }
  return true;
}

/// Copies the samples of a row to their positions in the picture.
void place_row(const ImageInfo& info, const Pass& pass, int64_t y, std::span<const uint8_t> row,
               std::span<std::byte> out) {
  const int64_t columns = pass.columns(info.width);
  for (int64_t i = 0; i < columns; ++i) {
    const auto at = static_cast<size_t>(y * info.width + pass.x0 + i * pass.dx);
    const auto from = static_cast<size_t>(i);
    if (info.bits == 16) {
      const auto sample = static_cast<uint16_t>(row[2 * from] << 8 | row[2 * from + 1]);
      std::memcpy(out.data() + 2 * at, &sample, 2);
      continue;
    }
    const auto bits = static_cast<size_t>(info.bits);
    const size_t shift = 8 - bits - from * bits % 8;
    out[at] = static_cast<std::byte>(row[from * bits / 8] >> shift & ((1u << bits) - 1));
  }
}

}  // namespace

std::optional<ImageInfo> png_info(std::span<const uint8_t> file) {
  size_t at = kSignature;
  const auto header = next_chunk(file, at);
  if (!header || header->name != "IHDR" || header->data.size() != 13) return std::nullopt;
  ImageInfo info;
  info.format = "PNG";
  info.width = number_at(header->data, 0);
  info.height = number_at(header->data, 4);
  info.bits = header->data[8];
  const int colours = header->data[9];
  info.is_interlaced = header->data[12] == 1;
  constexpr std::array<int, 7> kChannels{1, 0, 3, 3, 2, 0, 4};
  const bool is_known =
      colours <= 6 && kChannels[static_cast<size_t>(colours)] > 0 &&
      (info.bits == 1 || info.bits == 2 || info.bits == 4 || info.bits == 8 || info.bits == 16);
  if (!is_known || info.width == 0 || info.height == 0 || header->data[10] != 0 ||
      header->data[11] != 0 || header->data[12] > 1) {
    return std::nullopt;
  }
  info.channels = kChannels[static_cast<size_t>(colours)];
  while (const auto chunk = next_chunk(file, at)) {
    if (chunk->name == "IDAT") break;
    if (chunk->name == "pHYs" && chunk->data.size() == 9 && chunk->data[8] == 1) {
      info.density_x = number_at(chunk->data, 0);
      info.density_y = number_at(chunk->data, 4);
    }
  }
  return info;
}

bool decode_png(std::span<const uint8_t> file, const ImageInfo& info, std::span<std::byte> out) {
  std::vector<uint8_t> packed;
  bool has_end = false;
  for (size_t at = kSignature; !has_end;) {
    const auto chunk = next_chunk(file, at);
    if (!chunk) return false;
    if (chunk->name == "IDAT") packed.insert(packed.end(), chunk->data.begin(), chunk->data.end());
    has_end = chunk->name == "IEND";
  }
  size_t size = 0;
  for (const Pass& pass : passes_of(info)) {
    const int64_t columns = pass.columns(info.width);
    if (columns > 0) {
      size += (row_bytes(info, columns) + 1) * static_cast<size_t>(pass.rows(info.height));
    }
  }
  if (size / kMostDeflateExpansion > packed.size()) return false;
  std::vector<uint8_t> rows(size);
  ZlibInflater inflater;
  if (inflater.inflate(packed, rows) != ZlibInflater::Outcome::exact) return false;
  const size_t step = std::max<size_t>(1, static_cast<size_t>(info.bits) / 8);
  size_t at = 0;
  for (const Pass& pass : passes_of(info)) {
    const int64_t columns = pass.columns(info.width);
    if (columns == 0) continue;
    const size_t bytes = row_bytes(info, columns);
    const std::vector<uint8_t> none(bytes);
    std::span<const uint8_t> above = none;
    for (int64_t i = 0; i < pass.rows(info.height); ++i, at += bytes + 1) {
      const auto row = std::span(rows).subspan(at + 1, bytes);
      if (!unfilter(rows[at], step, above, row)) return false;
      place_row(info, pass, pass.y0 + i * pass.dy, row, out);
      above = row;
    }
  }
  return true;
}

}  // namespace isosplat::import
