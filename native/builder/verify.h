#pragma once

#include <filesystem>
#include <functional>

#include "shared/core/store/store_reader.h"
#include "shared/system/posix_file/file_parts.h"

namespace isosplat {

struct VerifyOptions {
  unsigned threads = 0;  ///< 0: one per core
  /// Called after each chunk with the fraction of the file that has been checked, one call at a
  /// time.
  std::function<void(double fraction)> progress;
};

struct VerifyReport {
  StoreInfo info;
  uint64_t chunks = 0;        ///< decoded chunks
  uint64_t cells = 0;         ///< cells of these chunks; a cell counts once for each of its bands
  uint64_t field_chunks = 0;  ///< decoded field chunks
};

/// Decodes a whole store and checks all guarantees of its format:
/// - the file has the size that its header states, and its bytes hash to the content id;
/// - the header, every page and every chunk match their checksums;
/// - the chunks of each level are contiguous and in raster order;
/// - each block's bands tile its interval, which is the union of its cells' intervals;
/// - each chunk decodes to its number of cells, in raster order, and each cell is in exactly the
///   bands that its interval intersects;
/// - a voxel and a cell's interval are the same in all bands of a block; at level 0 the interval is
///   that of the cell's corners;
/// - the interval of a coarse cell contains those of the cells that it covers;
/// - the fields satisfy what verify_fields() states.
/// Returns the error of the first check that fails. Errors: io_error, and those of StoreReader and
/// ChunkDecoder.
Result<VerifyReport> verify_store_file(const std::filesystem::path& path,
                                       const VerifyOptions& options = {});

/// The same for a store that is a part of a file, such as a bundle.
Result<VerifyReport> verify_store(const FileParts& file, const VerifyOptions& options = {});

}  // namespace isosplat
