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

// The thumbnail of a store or a scene: a small picture for lists, in a PNG file beside it
// (`head.isosplat.png` for `head.isosplat`). Its first text chunk names the content id that it
// shows, so that a picture of another content is never served:
//
//     signature | IHDR | tEXt "Isosplat content", 0, hexadecimal digits | … IDAT … | IEND
//
// A store's content id has 32 digits, a scene's 16.
namespace isosplat::server {

inline constexpr size_t kMaxThumbnailBytes = size_t{1} << 20;
inline constexpr uint32_t kMaxThumbnailSize = 2048;  ///< pixels of each side

/// The path of a store's thumbnail.
std::filesystem::path thumbnail_path(const std::filesystem::path& store);

/// A PNG with the text chunk of this content id behind its IHDR. Requires a
/// PNG as libpng writes it.
std::vector<std::byte> with_content_id(std::span<const std::byte> png, std::string_view content);

/// The content id that a PNG file names, from its first bytes; empty if there is no such file, or
/// if it names none. Does not check the rest of the file: read_thumbnail() does.
std::string thumbnail_content(const std::filesystem::path& png);
/// The same for an open file.
std::string thumbnail_content(const RandomAccessFile& png);

/// The bytes of a store's thumbnail. Checks its whole structure: sizes, checksums, and that it has
/// only chunks that a picture needs. Errors: not_found (no file, a picture of another content, or a
/// PNG that fails these checks).
Result<std::vector<std::byte>> read_thumbnail(const std::filesystem::path& store,
                                              std::string_view content);

/// The same check for bytes in memory.
bool is_thumbnail(std::span<const std::byte> png, std::string_view content);

}  // namespace isosplat::server
