#include "server/catalog/thumbnail.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>

#include "shared/system/posix_file/posix_file.h"

namespace isosplat::server {
namespace {

constexpr std::string_view kContentChunk = "ISOS";
constexpr size_t kStoreDigits = 32, kSceneDigits = 16;  // of content ids
constexpr size_t kChecksumDigits = 8;
constexpr size_t kFileHeaderBytes = 12;  // "RIFF", the size of the rest, "WEBP"
constexpr size_t kChunkHeaderBytes = 8;  // type, the size of its data
constexpr size_t kCanvasBytes = 10;      // of the data of VP8X: flags, 3 unused, width, height
constexpr char kHasAlpha = 0x10;         // in the flags of VP8X

/// Up to the end of the chunk with the content id.
constexpr size_t kBeginningBytes =
    kFileHeaderBytes + 2 * kChunkHeaderBytes + kCanvasBytes + kStoreDigits + kChecksumDigits;

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The first `count` bytes, at most 4.
uint32_t little_endian(std::string_view bytes, size_t count) {
  uint32_t number = 0;
  for (size_t i = count; i-- > 0;) number = number << 8 | static_cast<uint8_t>(bytes[i]);
  return number;
}

std::string little_endian_bytes(size_t number, size_t count) {
  std::string bytes;
  for (size_t i = 0; i < count; ++i) bytes += static_cast<char>(number >> 8 * i);
  return bytes;
}

std::string checksum(std::string_view bytes) {
  const auto sum =
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));
  return fmt::format("{:08x}", sum);
}

std::string file_header(size_t chunk_bytes) {
  return "RIFF" + little_endian_bytes(chunk_bytes + 4, 4) + "WEBP";
}

std::string chunk_of(std::string_view type, std::string_view data) {
  return std::string(type) + little_endian_bytes(data.size(), 4) + std::string(data);
}

/// Type, size of the data (4 bytes), data, and a zero if their number is odd.
struct Chunk {
  std::string_view type, data;
};

/// Removes the first chunk of `rest`, and returns it; null if it is malformed.
std::optional<Chunk> take_chunk(std::string_view& rest) {
  if (rest.size() < kChunkHeaderBytes) return std::nullopt;
  const size_t size = little_endian(rest.substr(4), 4);
  const size_t padding = size & 1;
  if (rest.size() - kChunkHeaderBytes < size + padding) return std::nullopt;
  const Chunk chunk{rest.substr(0, 4), rest.substr(kChunkHeaderBytes, size)};
  rest.remove_prefix(kChunkHeaderBytes + size + padding);
  return chunk;
}

/// Pixels.
struct Size {
  uint32_t width, height;

  friend bool operator==(const Size&, const Size&) = default;
};

/// The size that the header of a compressed picture states (RFC 6386, 9.1; RFC 9649, 3.4); null for
/// other chunks.
std::optional<Size> picture_size(const Chunk& chunk) {
  if (chunk.data.size() < 10) return std::nullopt;
  if (chunk.type == "VP8 " && chunk.data.substr(3, 3) == "\x9d\x01\x2a") {
    return Size{little_endian(chunk.data.substr(6), 2) & 0x3fff,
                little_endian(chunk.data.substr(8), 2) & 0x3fff};
  }
  if (chunk.type == "VP8L" && chunk.data[0] == '\x2f') {
    const uint32_t bits = little_endian(chunk.data.substr(1), 4);
    return Size{(bits & 0x3fff) + 1, (bits >> 14 & 0x3fff) + 1};
  }
  return std::nullopt;
}

/// The size that VP8X states; null for other chunks, and if it announces more than a still picture.
std::optional<Size> canvas_size(const Chunk& chunk) {
  if (chunk.type != "VP8X" || chunk.data.size() != kCanvasBytes) return std::nullopt;
  if ((chunk.data[0] & ~kHasAlpha) != 0 || little_endian(chunk.data.substr(1), 3) != 0) {
    return std::nullopt;
  }
  return Size{little_endian(chunk.data.substr(4), 3) + 1,
              little_endian(chunk.data.substr(7), 3) + 1};
}

/// VP8X of an opaque picture.
std::string canvas_chunk(const Size& size) {
  return chunk_of("VP8X", std::string(4, '\0') + little_endian_bytes(size.width - 1, 3) +
                              little_endian_bytes(size.height - 1, 3));
}

bool is_content_digit(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
}

/// The content id in a chunk; empty if it has another type or form.
std::string content_of(const Chunk& chunk) {
  const size_t digits = chunk.data.size() - kChecksumDigits;
  if (chunk.type != kContentChunk || (digits != kStoreDigits && digits != kSceneDigits) ||
      !std::ranges::all_of(chunk.data, is_content_digit)) {
    return {};
  }
  return std::string(chunk.data.substr(0, digits));
}

}  // namespace

std::filesystem::path thumbnail_path(const std::filesystem::path& store) {
  std::filesystem::path path = store;
  path += kThumbnailExtension;
  return path;
}

std::vector<std::byte> with_content_id(std::span<const std::byte> webp, std::string_view content) {
  std::string chunks(text_of(webp.subspan(kFileHeaderBytes)));
  std::string_view rest = chunks;
  const auto first = take_chunk(rest);
  // Only files with VP8X may have further chunks.
  if (const auto size = first ? picture_size(*first) : std::nullopt) {
    chunks = canvas_chunk(*size) + chunks;
  }
  chunks.insert(kChunkHeaderBytes + kCanvasBytes,
                chunk_of(kContentChunk, std::string(content) + checksum(chunks)));
  const std::string bytes = file_header(chunks.size()) + chunks;
  const auto all = std::as_bytes(std::span(bytes));
  return {all.begin(), all.end()};
}

bool is_thumbnail(std::span<const std::byte> webp, std::string_view content) {
  const std::string_view all = text_of(webp);
  if (all.size() > kMaxThumbnailBytes || all.size() < kFileHeaderBytes ||
      all.substr(0, kFileHeaderBytes) != file_header(all.size() - kFileHeaderBytes)) {
    return false;
  }
  std::string_view rest = all.substr(kFileHeaderBytes);
  const auto canvas = take_chunk(rest);
  const auto size = canvas ? canvas_size(*canvas) : std::nullopt;
  if (!size || size->width > kMaxThumbnailSize || size->height > kMaxThumbnailSize) return false;
  const std::string_view before = all.substr(kFileHeaderBytes, kChunkHeaderBytes + kCanvasBytes);
  const auto id = take_chunk(rest);
  if (!id || content.empty() || content_of(*id) != content) return false;
  if (!id->data.ends_with(checksum(std::string(before) + std::string(rest)))) return false;
  auto picture = take_chunk(rest);
  if (picture && picture->type == "ALPH") picture = take_chunk(rest);
  return picture && picture_size(*picture) == size && rest.empty();
}

std::string thumbnail_content(const std::filesystem::path& webp) {
  const auto file = PosixFile::open(webp);
  return file ? thumbnail_content(*file) : std::string();
}

std::string thumbnail_content(const RandomAccessFile& webp) {
  std::array<std::byte, kBeginningBytes> bytes;
  if (const auto read = webp.read(0, bytes); !read) return {};
  std::string_view rest = text_of(bytes);
  if (!rest.starts_with("RIFF") || rest.substr(8, 4) != "WEBP") return {};
  rest.remove_prefix(kFileHeaderBytes);
  const auto canvas = take_chunk(rest);
  const auto id = canvas ? take_chunk(rest) : std::nullopt;
  return id ? content_of(*id) : std::string();
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
