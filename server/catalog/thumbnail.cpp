#include "server/catalog/thumbnail.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>

#include "shared/system/posix_file/posix_file.h"

namespace isosplat::server {
namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kKey{"Isosplat content\0", 17};
constexpr size_t kStoreDigits = 32, kSceneDigits = 16;  // of content ids
constexpr size_t kHeaderBytes = 13;                     // of the data of IHDR
constexpr size_t kChunkOverhead = 12;                   // length, type and checksum
constexpr size_t kMaxLength = 1 << 30;                  // of a chunk

/// Offset of the text chunk, and the number of bytes up to its end.
constexpr size_t kTextBegin = 8 + kChunkOverhead + kHeaderBytes;
constexpr size_t kTextEnd = kTextBegin + kChunkOverhead + kKey.size() + kStoreDigits;

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

uint32_t big_endian(std::string_view bytes) {
  uint32_t number = 0;
  for (size_t i = 0; i < 4; ++i) number = number << 8 | static_cast<uint8_t>(bytes[i]);
  return number;
}

uint32_t checksum(std::string_view bytes) {
  return static_cast<uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

/// A chunk of a PNG: length (4 bytes), type (4), data, checksum of type and data (4).
struct PngChunk {
  std::string_view type, data;
};

/// Removes the first chunk of `rest`, and returns it; null if it is malformed.
std::optional<PngChunk> take_chunk(std::string_view& rest) {
  if (rest.size() < kChunkOverhead) return std::nullopt;
  const size_t length = big_endian(rest);
  if (length > kMaxLength || rest.size() - kChunkOverhead < length) return std::nullopt;
  if (checksum(rest.substr(4, 4 + length)) != big_endian(rest.substr(8 + length))) {
    return std::nullopt;
  }
  const PngChunk chunk{rest.substr(4, 4), rest.substr(8, length)};
  rest.remove_prefix(kChunkOverhead + length);
  return chunk;
}

/// Whether a picture has 8 bits per channel, is not interlaced, and has a size suitable for lists.
bool is_header(const PngChunk& chunk) {
  if (chunk.type != "IHDR" || chunk.data.size() != kHeaderBytes) return false;
  const auto is_size = [](uint32_t pixels) { return pixels >= 1 && pixels <= kMaxThumbnailSize; };
  constexpr std::string_view kColourTypes{"\0\2\3\4\6", 5};
  return is_size(big_endian(chunk.data)) && is_size(big_endian(chunk.data.substr(4))) &&
         chunk.data[8] == 8 && kColourTypes.find(chunk.data[9]) != std::string_view::npos &&
         chunk.data.substr(10) == std::string_view("\0\0\0", 3);
}

bool is_harmless(std::string_view type) {
  constexpr std::array<std::string_view, 6> kTypes{"PLTE", "tRNS", "gAMA", "cHRM", "sRGB", "pHYs"};
  return std::ranges::find(kTypes, type) != kTypes.end();
}

bool is_content_digit(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
}

void append_number(std::string& out, uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(number >> shift);
}

}  // namespace

std::filesystem::path thumbnail_path(const std::filesystem::path& store) {
  std::filesystem::path path = store;
  path += ".png";
  return path;
}

std::vector<std::byte> with_content_id(std::span<const std::byte> png, std::string_view content) {
  std::string chunk = "tEXt";
  chunk += kKey;
  chunk += content;
  std::string bytes(text_of(png.first(kTextBegin)));
  append_number(bytes, static_cast<uint32_t>(chunk.size() - 4));
  bytes += chunk;
  append_number(bytes, checksum(chunk));
  bytes += text_of(png.subspan(kTextBegin));
  const auto all = std::as_bytes(std::span(bytes));
  return {all.begin(), all.end()};
}

bool is_thumbnail(std::span<const std::byte> png, std::string_view content) {
  std::string_view rest = text_of(png);
  if (rest.size() > kMaxThumbnailBytes || !rest.starts_with(kSignature)) return false;
  rest.remove_prefix(kSignature.size());
  const auto header = take_chunk(rest);
  if (!header || !is_header(*header)) return false;
  const auto text = take_chunk(rest);
  if (!text || text->type != "tEXt" || !text->data.starts_with(kKey) ||
      text->data.substr(kKey.size()) != content) {
    return false;
  }
  bool has_pixels = false, are_pixels_over = false;
  for (;;) {
    const auto chunk = take_chunk(rest);
    if (!chunk) return false;
    if (chunk->type == "IEND") return has_pixels && chunk->data.empty() && rest.empty();
    if (chunk->type == "IDAT") {
      if (are_pixels_over) return false;  // they must be consecutive
      has_pixels = true;
    } else {
      if (!is_harmless(chunk->type)) return false;
      are_pixels_over = has_pixels;
    }
  }
}

std::string thumbnail_content(const std::filesystem::path& png) {
  const auto file = PosixFile::open(png);
  return file ? thumbnail_content(*file) : std::string();
}

std::string thumbnail_content(const RandomAccessFile& png) {
  std::array<std::byte, kTextEnd> bytes;
  if (const auto read = png.read(0, bytes); !read) return {};
  const std::string_view all = text_of(bytes);
  const size_t digits = big_endian(all.substr(kTextBegin)) - kKey.size();
  if (digits != kStoreDigits && digits != kSceneDigits) return {};
  const std::string_view content = all.substr(kTextBegin + 8 + kKey.size(), digits);
  const bool is_one = all.starts_with(kSignature) && all.substr(kTextBegin + 4, 4) == "tEXt" &&
                      all.substr(kTextBegin + 8).starts_with(kKey) &&
                      std::ranges::all_of(content, is_content_digit);
  return is_one ? std::string(content) : std::string();
}

Result<std::vector<std::byte>> read_thumbnail(const std::filesystem::path& store,
                                              std::string_view content) {
  const auto none = [] {
    return fail(Status::not_found, "this content has no thumbnail: isosplat build makes one");
  };
  const auto file = PosixFile::open(thumbnail_path(store));
  if (!file) return none();
  const auto identity = file->identity();
  if (!identity || identity->bytes > kMaxThumbnailBytes) return none();
  std::vector<std::byte> bytes(identity->bytes);
  if (const auto read = file->read(0, bytes); !read || !is_thumbnail(bytes, content)) return none();
  return bytes;
}

}  // namespace isosplat::server
