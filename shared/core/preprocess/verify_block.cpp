#include "shared/core/preprocess/verify_block.h"

#include <algorithm>

#include "shared/core/store/checksum.h"

namespace isosplat {
namespace {

constexpr const char* kRemedy = ": rebuild the store, or fetch it again";
constexpr CellInterval kNone{65535, 0};

tl::unexpected<Error> malformed(const ChunkRef& chunk, const std::string& what) {
  return fail(Status::malformed_chunk, name_of(chunk) + ": " + what + kRemedy);
}

}  // namespace

std::string name_of(const ChunkRef& chunk) {
  return "chunk " + chunk_name(chunk.block, chunk.band);
}

void BlockVerifier::begin(const BlockRef& block, Index3 cells) {
  block_ = block;
  cells_ = cells;
  const size_t count = static_cast<size_t>(cells.x * cells.y * cells.z);
  intervals_.assign(count, kNone);
  last_band_.assign(count, 0);
  voxels_.assign(static_cast<size_t>((cells.x + 1) * (cells.y + 1) * (cells.z + 1)), -1);
  united_ = kNone;
  reaching_ = 0;
}

Result<void> BlockVerifier::decode(const ChunkRef& chunk, std::span<const std::byte> bytes) {
  if (checksum32(bytes) != chunk.checksum) {
    return fail(Status::checksum_mismatch,
                name_of(chunk) + ": its checksum differs from the recorded one" + kRemedy);
  }
  if (chunk.cells > 0) {
    const ChunkShape shape{cells_, chunk.band_begin, chunk.band_end, chunk.cells,
                           chunk.block.level > 0};
    if (auto decoded = decoder_.decode(bytes, shape, decoded_); !decoded) {
      return fail(decoded.error().status, name_of(chunk) + ": " + decoded.error().message);
    }
  } else {
    decoded_.cell.clear();
  }
  if (decoded_.cell.size() != chunk.cells) {
    return malformed(chunk, "expected " + std::to_string(chunk.cells) + " cells, found " +
                                std::to_string(decoded_.cell.size()));
  }
  return {};
}

/// Checks a cell's interval against the band, its corners, and the band before.
Result<void> BlockVerifier::check_interval(const ChunkRef& chunk, size_t decoded, size_t at) {
  const CellInterval interval = decoded_.interval[decoded];
  if (std::max<uint32_t>(interval.min, chunk.band_begin) >=
      std::min<uint32_t>(interval.max, chunk.band_end)) {
    return malformed(chunk, "a cell is never active in the band");
  }
  if (chunk.block.level == 0 && interval != corner_interval(decoded_.corners[decoded])) {
    return malformed(chunk, "a cell's interval is not that of its corners");
  }
  const bool is_from_before = interval.min < chunk.band_begin;
  if (is_from_before ? last_band_[at] != chunk.band || intervals_[at] != interval
                     : last_band_[at] != 0) {
    return malformed(chunk, "a cell's interval contradicts the cells of the previous band");
  }
  last_band_[at] = static_cast<uint16_t>(chunk.band + 1);
  intervals_[at] = interval;
  united_.min = std::min(united_.min, interval.min);
  united_.max = std::max(united_.max, interval.max);
  return {};
}

/// Checks that a cell's corners have the values that they have in other cells.
Result<void> BlockVerifier::check_corners(const ChunkRef& chunk, size_t decoded, Index3 cell) {
  for (int32_t c = 0; c < 8; ++c) {
    const Index3 v{cell.x + (c & 1), cell.y + (c >> 1 & 1), cell.z + (c >> 2)};
    int32_t& voxel =
        voxels_[static_cast<size_t>((v.z * (cells_.y + 1) + v.y) * (cells_.x + 1) + v.x)];
    const int32_t corner = decoded_.corners[decoded][static_cast<size_t>(c)];
    if (voxel >= 0 && voxel != corner) return malformed(chunk, "a voxel has two values");
    voxel = corner;
  }
  return {};
}

Result<void> BlockVerifier::add(const ChunkRef& chunk, std::span<const std::byte> bytes) {
  if (auto done = decode(chunk, bytes); !done) return done;
  const uint32_t expected_from_before = reaching_;
  uint32_t from_before = 0;
  reaching_ = 0;
  int64_t previous = -1;
  for (size_t i = 0; i < decoded_.cell.size(); ++i) {
    const uint32_t packed = decoded_.cell[i];
    const Index3 cell{static_cast<int32_t>(packed & 63), static_cast<int32_t>(packed >> 6 & 63),
                      static_cast<int32_t>(packed >> 12)};
    if (cell.x >= cells_.x || cell.y >= cells_.y || cell.z >= cells_.z ||
        static_cast<int64_t>(packed) <= previous) {
      return malformed(chunk, "its cells are not in raster order within the block");
    }
    previous = packed;
    if (auto good = check_interval(chunk, i, cell_at(cell)); !good) return good;
    from_before += decoded_.interval[i].min < chunk.band_begin;
    reaching_ += decoded_.interval[i].max > chunk.band_end;
    if (auto good = check_corners(chunk, i, cell); !good) return good;
  }
  if (from_before != expected_from_before) {
    return malformed(chunk, "expected " + std::to_string(expected_from_before) +
                                " cells that reach into it from the band before, found " +
                                std::to_string(from_before));
  }
  return {};
}

Result<void> BlockVerifier::end() {
  if (block_.band_count == 0) return {};
  if (reaching_ != 0 || united_ != block_.interval) {
    return fail(Status::malformed_page,
                "block " + block_name(block_.key) + ": expected the interval " +
                    std::to_string(block_.interval.min) + " to " +
                    std::to_string(block_.interval.max) + ", found cells from " +
                    std::to_string(united_.min) + " to " + std::to_string(united_.max) + kRemedy);
  }
  return {};
}

void BlockVerifier::halve(HalvedBlock& halved) const {
  halved.cells = {(cells_.x + 1) / 2, (cells_.y + 1) / 2, (cells_.z + 1) / 2};
  halved.intervals.assign(static_cast<size_t>(halved.cells.x * halved.cells.y * halved.cells.z),
                          kNone);
  size_t at = 0;
  for (int32_t z = 0; z < cells_.z; ++z) {
    for (int32_t y = 0; y < cells_.y; ++y) {
      for (int32_t x = 0; x < cells_.x; ++x, ++at) {
        CellInterval& to = halved.intervals[static_cast<size_t>(
            (z / 2 * halved.cells.y + y / 2) * halved.cells.x + x / 2)];
        to.min = std::min(to.min, intervals_[at].min);
        to.max = std::max(to.max, intervals_[at].max);
      }
    }
  }
}

Result<void> BlockVerifier::contains(Index3 octant, const HalvedBlock& child) const {
  const Index3 first = octant * (kBlockCells / 2);
  size_t at = 0;
  for (int32_t z = 0; z < child.cells.z; ++z) {
    for (int32_t y = 0; y < child.cells.y; ++y) {
      for (int32_t x = 0; x < child.cells.x; ++x, ++at) {
        const CellInterval below = child.intervals[at];
        if (below.min >= below.max) continue;
        const CellInterval own = intervals_[cell_at(first + Index3{x, y, z})];
        if (below.min >= own.min && below.max <= own.max) continue;
        return fail(Status::malformed_chunk,
                    "block " + block_name(block_.key) +
                        ": a cell's interval does not contain those of the finer cells" + kRemedy);
      }
    }
  }
  return {};
}

}  // namespace isosplat
