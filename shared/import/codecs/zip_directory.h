#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "shared/import/bytes/byte_reader.h"

namespace isosplat::import {

/// A file in a ZIP archive.
struct ZipMember {
  std::string name;
  uint64_t header = 0;        ///< offset of its header
  uint64_t stored_bytes = 0;  ///< in the archive
  uint64_t bytes = 0;         ///< decompressed
  uint16_t method = 0;        ///< 0: stored, 8: deflated
  bool is_encrypted = false;
};

/// Reads the directory of an archive (APPNOTE.TXT, 4.3), also with 64-bit sizes. Errors: io_error,
/// truncated if the directory at the end is missing, malformed_volume, unsupported_format for
/// archives of more than 100,000 files.
Result<std::vector<ZipMember>> read_zip_directory(const std::filesystem::path& path);

/// Opens a file of an archive. Its size is exact if it is stored, else an upper bound. Errors:
/// io_error, malformed_volume, unsupported_format for other methods and encrypted files.
Result<std::unique_ptr<ByteReader>> open_zip_member(const std::filesystem::path& path,
                                                    const ZipMember& member);

}  // namespace isosplat::import
