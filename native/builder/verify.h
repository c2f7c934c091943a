#pragma once

#include <filesystem>
#include <functional>

#include "shared/store/store_reader.h"

namespace isosplat {

struct VerifyOptions {
  unsigned threads = 0;  ///< 0: one per core
  /// Called now and then with the share that is done, one call at a time.
  std::function<void(double fraction)> progress;
};

struct VerifyReport {
  StoreInfo info;
  uint64_t chunks = 0;  ///< decoded
  uint64_t cells = 0;   ///< in them; a cell counts in each band that it is active in
};

/// Checks everything that a store promises, and decodes all of it:
/// - the file has the size that its header states, and its bytes hash to the content id;
/// - the header, every page and every chunk match their checksums;
/// - the chunks of each level follow each other in raster order and leave no byte between them;
/// - each block's bands tile its interval, which is the union of its cells' intervals;
/// - each chunk decodes to its number of cells, in raster order, all of them active somewhere in
///   the band, and each cell is in exactly those bands that its interval meets;
/// - a voxel and a cell's interval are the same wherever they occur in a block; at level 0 the
///   interval is that of the cell's corners;
/// - a coarse cell's interval contains those of the cells below it.
/// The error is the first of these that does not hold. Errors: io_error, and those of StoreReader
/// and ChunkDecoder.
Result<VerifyReport> verify_store_file(const std::filesystem::path& path,
                                       const VerifyOptions& options = {});

}  // namespace isosplat
