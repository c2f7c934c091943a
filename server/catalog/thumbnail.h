#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/system/posix_file/random_access_file.h"

// The thumbnail of a store or a scene: a small picture for lists, in a WebP file beside it
// (`head.isosplat.webp` for `head.isosplat`). Its second chunk names the content id that it shows,
// so that a picture of another content is never served, and has the CRC-32 of all other chunks, so
// that a damaged one is not served either:
//
//     RIFF header | VP8X | ISOS: content id, CRC-32 (8 digits) | ALPH (optional) | VP8 or VP8L
//
// A store's content id has 32 hexadecimal digits, a scene's 16. The other chunks are those of the
// WebP container specification (RFC 9649); readers ignore unknown ones.
namespace isosplat::server {

inline constexpr size_t kMaxThumbnailBytes = size_t{1} << 20;
inline constexpr uint32_t kMaxThumbnailSize = 2048;  ///< pixels of each side
inline constexpr std::string_view kThumbnailExtension = ".webp";

/// The path of a store's thumbnail.
std::filesystem::path thumbnail_path(const std::filesystem::path& store);

/// A WebP file with the chunk of this content id. Requires a WebP file as libwebp writes
/// it, of one still picture.
std::vector<std::byte> with_content_id(std::span<const std::byte> webp, std::string_view content);

/// The content id that a WebP file names, from its first bytes; empty if there is no such file, or
/// if it names none. Does not check the rest of the file: read_thumbnail() does.
std::string thumbnail_content(const std::filesystem::path& webp);
/// The same for an open file.
std::string thumbnail_content(const RandomAccessFile& webp);

/// The bytes of a store's thumbnail. Checks its whole structure: sizes, checksum, and that it has
/// only chunks that a picture needs. Errors: not_found (no file, a picture of another content, or a
/// WebP file that fails these checks).
Result<std::vector<std::byte>> read_thumbnail(const std::filesystem::path& store,
                                              std::string_view content);

/// The same check for bytes in memory.
bool is_thumbnail(std::span<const std::byte> webp, std::string_view content);

}  // namespace isosplat::server
