#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import {

/// Reads numbers as text from byte `start` of a file, separated by white space or commas, as
/// native-endian voxels of `type`. Reading forwards is fast; reading backwards starts again from
/// the beginning. Uses about 64 KB of memory. "nan" and "inf" are valid for floating-point types.
///
/// `end`: where the text ends, such as at the next tag; nothing: at the end of the file, where the
/// last number must be followed by white space, since it may be cut off.
///
/// Errors: io_error; on reading, malformed_volume for a word that is not a number of the type, with
/// its position, and truncated if the text ends early.
Result<std::unique_ptr<ByteReader>> open_text_voxels(const std::filesystem::path& path,
                                                     uint64_t start, VoxelType type,
                                                     std::optional<uint64_t> end = std::nullopt);

/// Reads pairs of hexadecimal digits from byte `start` of a file, with any white space between them
/// (NRRD's encoding "hex"). Errors: as above.
Result<std::unique_ptr<ByteReader>> open_hex(const std::filesystem::path& path, uint64_t start);

}  // namespace isosplat::import
