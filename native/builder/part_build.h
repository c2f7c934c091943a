#pragma once

#include <filesystem>

#include "native/builder/block_file.h"
#include "native/builder/builder.h"

namespace isosplat {

struct PartReport {
  uint64_t blocks = 0;      ///< of level 0, in this part
  uint64_t all_blocks = 0;  ///< of level 0
  double seconds = 0;
};

/// Encodes one part of the blocks of level 0: of B blocks in raster order, part i of n has those
/// from ⌊B (i − 1) / n⌋ on, up to ⌊B i / n⌋. Writes them to a block file with their parts of level
/// 1 and their statistics. KeptBlocks::of_parts takes the files of all parts. The file appears when
/// it is complete. Reads the slices of the part, and what StoreBuild::begin() reads. Errors: those
/// of build_store_file; invalid_argument (no such part).
Result<PartReport> build_part_file(VolumeSource& source, const std::filesystem::path& target,
                                   const BuildOptions& options, Part part);

}  // namespace isosplat
