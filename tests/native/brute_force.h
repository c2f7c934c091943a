#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/store/checksum.h"
#include "shared/core/store/store_reader.h"

namespace isosplat {

/// A level computed without optimizations: the reference for stores.
struct PlainLevel {
  Index3 cells;
  std::vector<int32_t> voxels;          ///< quantized values; −1: missing
  std::vector<CellInterval> intervals;  ///< {65535, 0}: never active

  size_t voxel_at(int32_t x, int32_t y, int32_t z) const {
    return (static_cast<size_t>(z) * static_cast<size_t>(cells.y + 1) + static_cast<size_t>(y)) *
               static_cast<size_t>(cells.x + 1) +
           static_cast<size_t>(x);
  }
  size_t cell_at(int32_t x, int32_t y, int32_t z) const {
    return (static_cast<size_t>(z) * static_cast<size_t>(cells.y) + static_cast<size_t>(y)) *
               static_cast<size_t>(cells.x) +
           static_cast<size_t>(x);
  }
};

template <class Visit>
void for_each_cell(Index3 cells, Visit visit) {
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      for (int32_t x = 0; x < cells.x; ++x) visit(x, y, z);
    }
  }
}

/// Level 0 of a volume. The mapping of the store quantizes the values, one by one.
template <class T>
PlainLevel plain_level_0(Index3 n, const std::vector<T>& values, const ValueMapping& mapping) {
  PlainLevel level;
  level.cells = n - Index3{1, 1, 1};
  for (const T value : values) {
    const auto v = static_cast<double>(value);
    level.voxels.push_back(std::isfinite(v) ? static_cast<int32_t>(std::floor(
                                                  (v - mapping.offset) / mapping.scale + 0.5))
                                            : -1);
  }
  level.intervals.resize(static_cast<size_t>(level.cells.x) * static_cast<size_t>(level.cells.y) *
                         static_cast<size_t>(level.cells.z));
  for_each_cell(level.cells, [&](int32_t x, int32_t y, int32_t z) {
    int32_t low = 65535, high = 0;
    bool is_missing = false;
    for (int32_t c = 0; c < 8; ++c) {
      const int32_t v = level.voxels[level.voxel_at(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2))];
      is_missing |= v < 0;
      low = std::min(low, v);
      high = std::max(high, v);
    }
    level.intervals[level.cell_at(x, y, z)] =
        is_missing
            ? CellInterval{65535, 0}
            : CellInterval{static_cast<QuantizedValue>(low), static_cast<QuantizedValue>(high)};
  });
  return level;
}

inline PlainLevel plain_coarser(const PlainLevel& fine) {
  PlainLevel level;
  level.cells = {(fine.cells.x + 1) / 2, (fine.cells.y + 1) / 2, (fine.cells.z + 1) / 2};
  level.voxels.resize(static_cast<size_t>(level.cells.x + 1) *
                      static_cast<size_t>(level.cells.y + 1) *
                      static_cast<size_t>(level.cells.z + 1));
  for_each_cell(level.cells + Index3{1, 1, 1}, [&](int32_t x, int32_t y, int32_t z) {
    int64_t sum = 0, weight = 0;
    const int32_t cx = std::min(2 * x, fine.cells.x), cy = std::min(2 * y, fine.cells.y),
                  cz = std::min(2 * z, fine.cells.z);
    for (int32_t dz = -1; dz <= 1; ++dz) {
      for (int32_t dy = -1; dy <= 1; ++dy) {
        for (int32_t dx = -1; dx <= 1; ++dx) {
          const int32_t v = fine.voxels[fine.voxel_at(std::clamp(cx + dx, 0, fine.cells.x),
                                                      std::clamp(cy + dy, 0, fine.cells.y),
                                                      std::clamp(cz + dz, 0, fine.cells.z))];
          const int64_t w = (2 - std::abs(dx)) * (2 - std::abs(dy)) * (2 - std::abs(dz));
          if (v < 0) continue;
          sum += w * v;
          weight += w;
        }
      }
    }
    level.voxels[level.voxel_at(x, y, z)] =
        weight ? static_cast<int32_t>((sum + weight / 2) / weight) : -1;
  });
  level.intervals.resize(static_cast<size_t>(level.cells.x) * static_cast<size_t>(level.cells.y) *
                         static_cast<size_t>(level.cells.z));
  for_each_cell(level.cells, [&](int32_t x, int32_t y, int32_t z) {
    CellInterval united{65535, 0};
    for_each_cell({2, 2, 2}, [&](int32_t i, int32_t j, int32_t k) {
      const Index3 below{2 * x + i, 2 * y + j, 2 * z + k};
      if (below.x >= fine.cells.x || below.y >= fine.cells.y || below.z >= fine.cells.z) return;
      const CellInterval interval = fine.intervals[fine.cell_at(below.x, below.y, below.z)];
      united.min = std::min(united.min, interval.min);
      united.max = std::max(united.max, interval.max);
    });
    level.intervals[level.cell_at(x, y, z)] = united;
  });
  return level;
}

/// Rounds the intervals of each block of a coarse level as the builder does (round_intervals.h).
inline void round_plainly(PlainLevel& level) {
  for_each_cell({(level.cells.x + 63) / 64, (level.cells.y + 63) / 64, (level.cells.z + 63) / 64},
                [&](int32_t bx, int32_t by, int32_t bz) {
                  std::vector<CellInterval*> active;
                  for_each_cell({64, 64, 64}, [&](int32_t i, int32_t j, int32_t k) {
                    const Index3 at{bx * 64 + i, by * 64 + j, bz * 64 + k};
                    if (at.x >= level.cells.x || at.y >= level.cells.y || at.z >= level.cells.z)
                      return;
                    CellInterval& interval = level.intervals[level.cell_at(at.x, at.y, at.z)];
                    if (interval.min < interval.max) active.push_back(&interval);
                  });
                  int quantum = 1;
                  for (int next = 2; next <= 128; next *= 2) {
                    const auto wide = std::count_if(
                        active.begin(), active.end(),
                        [&](const CellInterval* c) { return c->max - c->min >= 2 * next; });
                    if (5 * static_cast<size_t>(wide) >= 4 * active.size()) quantum = next;
                  }
                  for (CellInterval* c : active) {
                    c->min = static_cast<QuantizedValue>(c->min / quantum * quantum);
                    c->max = static_cast<QuantizedValue>(c->max / quantum * quantum + quantum - 1);
                  }
                });
}

/// A reader of a whole store in memory, with all pages.
inline StoreReader open_whole(std::span<const std::byte> store) {
  auto reader = StoreReader::open(store);
  if (!reader) throw std::runtime_error(reader.error().message);
  for (uint32_t i = 0; i < reader->pages().size(); ++i) {
    const PageRef page = reader->pages()[i];
    if (auto added = reader->add_page(i, store.subspan(page.offset, page.bytes)); !added) {
      throw std::runtime_error(added.error().message);
    }
  }
  return std::move(*reader);
}

/// Checks that at each level, for quantized isovalues at voxel values, between them, at the ends of
/// the range and beyond, the store yields exactly the active cells, each once, with the corners and
/// intervals of the reference. A coarse cell that contains an active cell must be active too.
template <class T>
void expect_store_of(std::span<const std::byte> store, Index3 n, const std::vector<T>& values) {
  const StoreReader reader = open_whole(store);
  const StoreInfo& info = reader.info();
  PlainLevel level = plain_level_0(n, values, info.mapping), finer;
  std::set<float> quantized_isovalues = {-1, 0, 65535, 70000};
  for (const QuantizedValue end : {info.range.min, info.range.max}) {
    for (const float d : {-1.f, -0.5f, 0.f, 0.5f, 1.f}) quantized_isovalues.insert(end + d);
  }
  for (size_t i = 1; i < 8; ++i) {
    const auto v = static_cast<float>(level.voxels[i * (level.voxels.size() - 1) / 8]);
    quantized_isovalues.insert({v, v + 0.5f, v + 0.25f});
  }
  ChunkDecoder decoder;
  DecodedCells decoded;
  for (uint32_t l = 0; l < info.levels; ++l) {
    if (l > 0) {
      finer = std::move(level);
      level = plain_coarser(finer);
      round_plainly(level);
    }
    const LevelGrid grid = level_grid(n, l);
    ASSERT_EQ(grid.cells, level.cells);
    for (const float quantized_isovalue : quantized_isovalues) {
      SCOPED_TRACE(testing::Message()
                   << "level " << l << " quantized_isovalue " << quantized_isovalue);
      std::vector<uint8_t> found(level.intervals.size());
      const auto chunks = reader.chunks_for(l, quantized_isovalue, quantized_isovalue);
      ASSERT_TRUE(chunks);
      std::set<std::tuple<int32_t, int32_t, int32_t>> blocks;
      for (const ChunkRef& chunk : *chunks) {
        const Index3 block = chunk.block.index;
        ASSERT_TRUE(blocks.emplace(block.x, block.y, block.z).second) << "two chunks for one block";
        ASSERT_EQ(reader.chunk_for(chunk.block, quantized_isovalue)->value().band, chunk.band);
        const auto bytes = store.subspan(chunk.offset, chunk.bytes);
        ASSERT_EQ(checksum32(bytes), chunk.checksum);
        const ChunkShape shape{block_cells(grid, block), chunk.band_begin, chunk.band_end,
                               chunk.cells, l > 0};
        const auto result = decoder.decode(bytes, shape, decoded);
        ASSERT_TRUE(result) << result.error().message;
        for (size_t i = 0; i < decoded.cell.size(); ++i) {
          if (!is_active(decoded.interval[i], quantized_isovalue)) continue;
          const uint32_t c = decoded.cell[i];
          const Index3 at{block.x * kBlockCells + static_cast<int32_t>(c & 63),
                          block.y * kBlockCells + static_cast<int32_t>(c >> 6 & 63),
                          block.z * kBlockCells + static_cast<int32_t>(c >> 12)};
          const size_t cell = level.cell_at(at.x, at.y, at.z);
          ASSERT_EQ(found[cell]++, 0) << "a cell twice";
          ASSERT_EQ(decoded.interval[i], level.intervals[cell]);
          for (int32_t k = 0; k < 8; ++k) {
            ASSERT_EQ(
                decoded.corners[i][static_cast<size_t>(k)],
                level.voxels[level.voxel_at(at.x + (k & 1), at.y + (k >> 1 & 1), at.z + (k >> 2))]);
          }
        }
      }
      for (size_t i = 0; i < found.size(); ++i) {
        ASSERT_EQ(found[i] != 0, is_active(level.intervals[i], quantized_isovalue)) << i;
      }
      if (l == 0) continue;
      for_each_cell(finer.cells, [&](int32_t x, int32_t y, int32_t z) {
        if (is_active(finer.intervals[finer.cell_at(x, y, z)], quantized_isovalue)) {
          EXPECT_TRUE(found[level.cell_at(x / 2, y / 2, z / 2)]);
        }
      });
    }
  }
}

}  // namespace isosplat
