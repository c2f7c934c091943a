#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/store/store_writer.h"

namespace isosplat::fixture {

/// One level of a volume in memory: its voxels, and the interval of each cell.
struct Level {
  LevelGrid grid;
  std::vector<QuantizedValue> voxels;
  std::vector<CellInterval> intervals;

  size_t voxel(int32_t x, int32_t y, int32_t z) const {
    return (static_cast<size_t>(z) * (grid.cells.y + 1) + y) * (grid.cells.x + 1) + x;
  }
  size_t cell(int32_t x, int32_t y, int32_t z) const {
    return (static_cast<size_t>(z) * grid.cells.y + y) * grid.cells.x + x;
  }
};

/// All levels of a volume. Coarse voxels are copies of fine ones, not averages, because these tests
/// use only the intervals of coarse levels.
inline std::vector<Level> make_levels(
    Index3 voxels, const std::function<QuantizedValue(int32_t, int32_t, int32_t)>& quantized) {
  std::vector<Level> levels;
  for (uint32_t l = 0; l < level_count(voxels); ++l) {
    Level level{level_grid(voxels, l), {}, {}};
    const Index3 n = level.grid.cells;
    for (int32_t z = 0; z <= n.z; ++z) {
      for (int32_t y = 0; y <= n.y; ++y) {
        for (int32_t x = 0; x <= n.x; ++x) {
          level.voxels.push_back(quantized(std::min(x << l, voxels.x - 1),
                                           std::min(y << l, voxels.y - 1),
                                           std::min(z << l, voxels.z - 1)));
        }
      }
    }
    for (int32_t z = 0; z < n.z; ++z) {
      for (int32_t y = 0; y < n.y; ++y) {
        for (int32_t x = 0; x < n.x; ++x) {
          CellInterval interval{65535, 0};
          for (int32_t i = 0; i < 8; ++i) {
            CellInterval part;
            if (l == 0) {
              const QuantizedValue v =
                  level.voxels[level.voxel(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2))];
              part = {v, v};
            } else {
              const Level& below = levels.back();
              const Index3 c{2 * x + (i & 1), 2 * y + (i >> 1 & 1), 2 * z + (i >> 2)};
              if (c.x >= below.grid.cells.x || c.y >= below.grid.cells.y ||
                  c.z >= below.grid.cells.z) {
                continue;
              }
              part = below.intervals[below.cell(c.x, c.y, c.z)];
            }
            interval.min = std::min(interval.min, part.min);
            interval.max = std::max(interval.max, part.max);
          }
          level.intervals.push_back(interval);
        }
      }
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

/// Writes a store whose bands are `band_values` quantized values wide.
inline std::vector<std::byte> make_store(const std::vector<Level>& levels, uint32_t band_values) {
  const Index3 cells = levels[0].grid.cells;
  const Index3 voxels{cells.x + 1, cells.y + 1, cells.z + 1};
  MemorySink sink;
  auto writer = StoreWriter::create(voxels, 4096, sink);
  if (!writer) return {};
  ChunkEncoder encoder;
  CellInterval range{65535, 0};
  for (const Level& level : levels) {
    const Index3 blocks = level.grid.blocks;
    for (int32_t b = 0; b < static_cast<int32_t>(level.grid.block_count()); ++b) {
      const Index3 index{b % blocks.x, b / blocks.x % blocks.y, b / blocks.x / blocks.y};
      const Index3 first{index.x * kBlockCells, index.y * kBlockCells, index.z * kBlockCells};
      const Index3 n = block_cells(level.grid, index);
      std::vector<QuantizedValue> block_voxels;
      std::vector<CellInterval> intervals;
      CellInterval all{65535, 0};
      for (int32_t z = 0; z <= n.z; ++z) {
        for (int32_t y = 0; y <= n.y; ++y) {
          for (int32_t x = 0; x <= n.x; ++x) {
            block_voxels.push_back(
                level.voxels[level.voxel(first.x + x, first.y + y, first.z + z)]);
            if (x == n.x || y == n.y || z == n.z) continue;
            intervals.push_back(level.intervals[level.cell(first.x + x, first.y + y, first.z + z)]);
            all.min = std::min(all.min, intervals.back().min);
            all.max = std::max(all.max, intervals.back().max);
          }
        }
      }
      range.min = std::min(range.min, all.min);
      range.max = std::max(range.max, all.max);
      const BlockVoxels view{n, block_voxels.data(), intervals.data(), level.grid.level > 0};
      std::vector<BandChunk> bands;
      std::vector<std::byte> bytes;
      for (uint32_t begin = all.min; begin < all.max;) {
        const uint32_t end = std::min<uint32_t>((begin / band_values + 1) * band_values, all.max);
        const size_t before = bytes.size();
        const uint32_t count = encoder.encode(view, begin, end, bytes);
        bands.push_back({end, count, static_cast<uint32_t>(bytes.size() - before)});
        begin = end;
      }
      if (!writer->add_block(all.min < all.max ? all : CellInterval{}, bands, bytes)) return {};
    }
  }
  StoreInfo info;
  info.grid.voxels = voxels;
  info.grid.spacing = {1, 1, 1.5};
  info.grid.origin = {-10, 20, 30};
  info.mapping.offset = -100;
  info.mapping.scale = 1;
  info.mapping.bits = 16;
  info.range = range;
  info.metadata = R"({"name":"test","suggested_isovalues":[100.5]})";
  if (!writer->finish(info)) return {};
  return std::move(sink.bytes);
}

/// A ball with a rough surface, computed with integers, so that all languages get the same numbers.
/// Quantized values decrease from 600 at the centre with the squared distance; a hash adds noise.
inline QuantizedValue rough_ball(Index3 voxels, int32_t x, int32_t y, int32_t z) {
  const int32_t dx = 2 * x - voxels.x, dy = 2 * y - voxels.y, dz = 2 * z - voxels.z;
  const int32_t smallest = std::min({voxels.x, voxels.y, voxels.z});
  const int32_t fall = 600 * (dx * dx + dy * dy + dz * dz) / (smallest * smallest * 2);
  const uint32_t hash = static_cast<uint32_t>(x * 31 + y * 17 + z * 7) * 2654435761u >> 29;
  return static_cast<QuantizedValue>(std::max(0, 600 - fall) + static_cast<int32_t>(hash));
}

/// A reader with all directory pages.
inline StoreReader open_store(std::span<const std::byte> bytes) {
  auto reader = StoreReader::open(bytes.first(std::min(bytes.size(), kMaxStoreHeaderBytes)));
  for (uint32_t i = 0; i < reader->pages().size(); ++i) {
    const PageRef& page = reader->pages()[i];
    (void)reader->add_page(i, bytes.subspan(static_cast<size_t>(page.offset), page.bytes));
  }
  return std::move(*reader);
}

}  // namespace isosplat::fixture
