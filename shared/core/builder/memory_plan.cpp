#include "shared/core/builder/memory_plan.h"

#include <algorithm>
#include <string>

#include "shared/core/builder/quantized_reader.h"
#include "shared/core/preprocess/layer.h"

namespace isosplat {
namespace {

/// Scratch memory of a thread: statistics, planner, encoder, the gathered block and its chunks.
constexpr uint64_t kThreadBytes = 20 << 20;

/// The program itself, the output's buffer, and encoded blocks that wait for earlier ones.
constexpr uint64_t kBaseBytes = 48 << 20;

/// The directory: a record per block, and about twelve chunk records per block.
constexpr uint64_t kDirectoryBytesPerBlock = 24 + 12 * 16;

std::string mebibytes(uint64_t bytes) {
  return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB";
}

}  // namespace

Result<MemoryPlan> plan_memory(const VolumeHeader& header, uint64_t source_bytes, unsigned encoders,
                               bool has_temporary_files, uint64_t limit) {
  const Index3 voxels = header.grid.voxels;
  const auto bits = static_cast<uint8_t>(voxel_bytes(header.type) == 1 ? 8 : 16);
  const uint32_t levels = level_count(voxels);

  uint64_t fixed =
      kBaseBytes + encoders * kThreadBytes + staging_bytes(header, bits) + source_bytes;
  // Bytes per level: the layer that is encoded, the part that is written from one finer layer, and
  // the whole level.
  std::vector<uint64_t> layer(levels), written(levels), whole(levels);
  for (uint32_t l = 0; l < levels; ++l) {
    const LevelGrid grid = level_grid(voxels, l);
    // As voxel_slice_bytes and interval_slice_bytes, in 64 bits: addresses may have 32.
    const uint64_t width = static_cast<uint32_t>(grid.cells.x);
    const uint64_t height = static_cast<uint32_t>(grid.cells.y);
    const uint64_t voxel_slice = (width + 1) * (height + 1) * (bits / 8u);
    const uint64_t interval_slice = width * height * (bits / 4u);
    const auto depth = static_cast<uint64_t>(std::min(grid.cells.z, kBlockCells));
    layer[l] = (depth + 1 + kVoxelsBefore) * voxel_slice + (l > 0 ? depth * interval_slice : 0);
    written[l] = (depth / 2 + 2) * voxel_slice + (depth / 2 + 1) * interval_slice;
    whole[l] = static_cast<uint64_t>(grid.cells.z + 1) * voxel_slice +
               static_cast<uint64_t>(grid.cells.z) * interval_slice;
    fixed += grid.block_count() * kDirectoryBytesPerBlock;
  }
  MemoryPlan plan;
  plan.in_memory.resize(levels, false);
  for (uint32_t l = 0; l < levels; ++l) {
    const uint64_t current = plan.in_memory[l] ? whole[l] : layer[l];
    uint64_t min_next = 0;
    if (l + 1 < levels) {
      min_next = has_temporary_files ? std::min(written[l + 1], whole[l + 1]) : whole[l + 1];
    }
    const uint64_t min_current = has_temporary_files ? layer[l] : current;
    plan.min_bytes = std::max(plan.min_bytes, fixed + min_current + min_next);
    uint64_t next = min_next;
    if (l + 1 < levels && (!has_temporary_files || fixed + current + whole[l + 1] <= limit)) {
      plan.in_memory[l + 1] = true;
      next = whole[l + 1];
    }
    plan.bytes = std::max(plan.bytes, fixed + current + next);
  }
  if (plan.min_bytes > limit && !has_temporary_files) {
    return fail(Status::out_of_memory,
                "expected a volume whose store can be built in " + mebibytes(limit) +
                    " of memory, found one that needs " + mebibytes(plan.min_bytes) +
                    ": build it with the program, which keeps in files what does not fit "
                    "(isosplat build)");
  }
  if (plan.min_bytes > limit) {
    std::string reason;
    if (source_bytes > 0) {
      reason = " this format is read into memory at once (" + mebibytes(source_bytes) +
               "), unlike raw files and uncompressed NRRD;";
    }
    return fail(Status::out_of_memory,
                "expected a memory limit of at least " + mebibytes(plan.min_bytes) + ", found " +
                    mebibytes(limit) + ":" + reason + " raise it (--memory " +
                    std::to_string((plan.min_bytes >> 20) + 1) + "M)");
  }
  return plan;
}

}  // namespace isosplat
