#include "shared/core/builder/memory_plan.h"

#include <algorithm>
#include <string>

#include "shared/core/builder/quantized_reader.h"

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

/// The memory for parts of one level, in bytes. 64 bits: addresses may have 32.
class LevelBytes {
 public:
  LevelBytes(Index3 voxels, uint32_t level, uint8_t bits)
      : grid_(level_grid(voxels, level)),
        voxel_(bits / 8u),
        depth_(static_cast<uint64_t>(std::min(grid_.cells.z, kBlockCells))) {}

  /// A band of `rows` rows of blocks, which is encoded.
  uint64_t band(int32_t rows) const {
    const uint64_t cells = cell_rows(rows, kBlockCells);
    const uint64_t voxels = std::min(cells + 1 + kVoxelsBefore, height() + 1);
    return (depth_ + 1 + kVoxelsBefore) * voxels * (width() + 1) * voxel_ +
           (grid_.level > 0 ? depth_ * cells * width() * 2 * voxel_ : 0);
  }
  /// The part of this level that a band of `rows` rows of blocks of the next finer level writes.
  uint64_t written(int32_t rows) const {
    const uint64_t cells = cell_rows(rows, kBlockCells / 2);
    const auto slices = static_cast<uint64_t>(std::min(grid_.cells.z, kBlockCells / 2));
    return (slices + 1) * (cells + 1) * (width() + 1) * voxel_ +
           slices * cells * width() * 2 * voxel_;
  }
  uint64_t whole() const {
    const auto slices = static_cast<uint64_t>(grid_.cells.z);
    return (slices + 1) * (height() + 1) * (width() + 1) * voxel_ +
           slices * height() * width() * 2 * voxel_;
  }
  int32_t rows() const { return grid_.blocks.y; }

 private:
  uint64_t width() const { return static_cast<uint32_t>(grid_.cells.x); }
  uint64_t height() const { return static_cast<uint32_t>(grid_.cells.y); }
  uint64_t cell_rows(int32_t rows, int32_t each) const {
    return std::min(static_cast<uint64_t>(rows) * static_cast<uint64_t>(each), height());
  }

  const LevelGrid grid_;
  const uint64_t voxel_, depth_;
};

/// The most rows of blocks for which bytes(rows) is at most `limit`, such that all bands of a layer
/// have about as many. 1 if none fits.
template <class Bytes>
int32_t fitting_rows(int32_t all, uint64_t limit, Bytes bytes) {
  int32_t fits = 1, too_many = all + 1;
  while (too_many - fits > 1) {
    const int32_t middle = fits + (too_many - fits) / 2;
    (bytes(middle) <= limit ? fits : too_many) = middle;
  }
  const int32_t bands = (all + fits - 1) / fits;
  return (all + bands - 1) / bands;
}

}  // namespace

Result<MemoryPlan> plan_memory(const VolumeHeader& header, uint64_t source_bytes, bool reads_rows,
                               unsigned encoders, bool has_temporary_files, uint64_t limit) {
  const Index3 voxels = header.grid.voxels;
  const auto bits = static_cast<uint8_t>(voxel_bytes(header.type) == 1 ? 8 : 16);
  const uint32_t levels = level_count(voxels);

  uint64_t fixed =
      kBaseBytes + encoders * kThreadBytes + staging_bytes(header, bits, reads_rows) + source_bytes;
  std::vector<LevelBytes> level;
  for (uint32_t l = 0; l < levels; ++l) {
    level.emplace_back(voxels, l, bits);
    fixed += level_grid(voxels, l).block_count() * kDirectoryBytesPerBlock;
  }
  MemoryPlan plan;
  plan.in_memory.resize(levels, false);
  for (uint32_t l = 0; l < levels; ++l) {
    const bool is_last = l + 1 == levels;
    const uint64_t whole_next = is_last ? 0 : level[l + 1].whole();
    const auto next = [&](int32_t rows) -> uint64_t {
      if (is_last) return 0;
      return has_temporary_files ? std::min(level[l + 1].written(rows), whole_next) : whole_next;
    };
    const auto current = [&](int32_t rows) {
      return plan.in_memory[l] ? level[l].whole() : level[l].band(rows);
    };
    const int32_t all = level[l].rows(), least = l > 0 || reads_rows ? 1 : all;
    const auto needed = [&](int32_t rows) { return fixed + current(rows) + next(rows); };
    const uint64_t min_current = has_temporary_files ? level[l].band(least) : current(least);
    plan.min_bytes = std::max(plan.min_bytes, fixed + min_current + next(least));
    int32_t rows = all;
    if (!is_last && (!has_temporary_files || fixed + current(all) + whole_next <= limit)) {
      plan.in_memory[l + 1] = true;
    } else if (least < all && needed(all) > limit) {
      rows = fitting_rows(all, limit, needed);
    }
    plan.band_rows.push_back(rows);
    const bool keeps_next = !is_last && plan.in_memory[l + 1];
    plan.bytes =
        std::max(plan.bytes, keeps_next ? fixed + current(rows) + whole_next : needed(rows));
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
    } else if (!reads_rows && level_grid(voxels, 0).blocks.y > 1) {
      reason =
          " this volume is read in whole slices, unlike uncompressed raw, NRRD, NumPy and MRC "
          "files, of which bands of rows suffice;";
    }
    return fail(Status::out_of_memory,
                "expected a memory limit of at least " + mebibytes(plan.min_bytes) + ", found " +
                    mebibytes(limit) + ":" + reason + " raise it (--memory " +
                    std::to_string((plan.min_bytes >> 20) + 1) + "M)");
  }
  return plan;
}

}  // namespace isosplat
