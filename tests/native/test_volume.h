#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "shared/core/sampling/packed_sample.h"
#include "shared/render/renderer.h"

namespace isosplat {

/// A volume in memory, and its samples, packed like those of chunk decoders. With it, tests and
/// benchmarks of drawing need no store.
struct TestVolume {
  VolumeGrid grid;
  ValueMapping mapping;
  std::vector<QuantizedValue> quantized_values;  // x fastest

  QuantizedValue at(int32_t x, int32_t y, int32_t z) const {
    return quantized_values[size_t(x) + size_t(grid.voxels.x) *
                                            (size_t(y) + size_t(grid.voxels.y) * size_t(z))];
  }
};

/// A volume of this many voxels whose quantized values are f at each voxel index, rounded and
/// clamped.
inline TestVolume sampled_volume(Index3 voxels, Vec3d spacing,
                                 const std::function<double(Vec3d)>& f) {
  TestVolume volume;
  volume.grid.voxels = voxels;
  volume.grid.spacing = spacing;
  volume.quantized_values.reserve(size_t(voxels.x) * size_t(voxels.y) * size_t(voxels.z));
  for (int32_t z = 0; z < voxels.z; ++z) {
    for (int32_t y = 0; y < voxels.y; ++y) {
      for (int32_t x = 0; x < voxels.x; ++x) {
        const double quantized = f({double(x), double(y), double(z)});
        volume.quantized_values.push_back(
            static_cast<QuantizedValue>(std::clamp(quantized + 0.5, 0.0, 65534.0)));
      }
    }
  }
  return volume;
}

/// A volume on this grid whose quantized values are f at each voxel's position in the world,
/// rounded and clamped.
inline TestVolume sampled_volume(const VolumeGrid& grid, const std::function<double(Vec3d)>& f) {
  TestVolume volume =
      sampled_volume(grid.voxels, grid.spacing, [&](Vec3d index) { return f(grid.world(index)); });
  volume.grid = grid;
  return volume;
}

/// A grid around `centre` with these axes (of any length) and this spacing. It contains a sphere of
/// this radius with a margin of two cells on each side.
inline VolumeGrid grid_about(Vec3d centre, double radius, Matrix3d axes, Vec3d spacing) {
  const auto inverse_length = [&](size_t axis) { return 1 / length(column(axes, axis)); };
  VolumeGrid grid;
  grid.direction = scale_columns(axes, {inverse_length(0), inverse_length(1), inverse_length(2)});
  grid.spacing = spacing;
  const Matrix3d dual = grid.dual_edges();
  const auto voxels = [&](size_t axis) {
    return 2 * static_cast<int32_t>(std::ceil(radius * length(column(dual, axis)) + 2)) + 1;
  };
  grid.voxels = {voxels(0), voxels(1), voxels(2)};
  grid.origin =
      grid.origin + centre -
      grid.world({0.5 * (grid.voxels.x - 1), 0.5 * (grid.voxels.y - 1), 0.5 * (grid.voxels.z - 1)});
  return grid;
}

/// Distance from the volume's centre in world units × 100: a sphere at isovalue 100 r.
inline TestVolume sphere_volume(Index3 voxels, Vec3d spacing = {1, 1, 1}) {
  const Vec3d centre{0.5 * (voxels.x - 1), 0.5 * (voxels.y - 1), 0.5 * (voxels.z - 1)};
  return sampled_volume(voxels, spacing, [=](Vec3d p) {
    const Vec3d d = p - centre;
    return 100 * length(Vec3d{d.x * spacing.x, d.y * spacing.y, d.z * spacing.z});
  });
}

/// The corners of a cell; the last voxel is repeated beyond the end.
inline CellCorners corners_at(const TestVolume& volume, int32_t x, int32_t y, int32_t z) {
  const Index3 n = volume.grid.voxels;
  const int32_t x1 = std::min(x + 1, n.x - 1), y1 = std::min(y + 1, n.y - 1),
                z1 = std::min(z + 1, n.z - 1);
  return {volume.at(x, y, z),  volume.at(x1, y, z),  volume.at(x, y1, z),  volume.at(x1, y1, z),
          volume.at(x, y, z1), volume.at(x1, y, z1), volume.at(x, y1, z1), volume.at(x1, y1, z1)};
}

/// The next coarser level's voxels: the [1 2 1]³ averages around every second voxel, as in stores.
inline TestVolume coarser_volume(const TestVolume& volume) {
  const Index3 last{volume.grid.voxels.x - 1, volume.grid.voxels.y - 1, volume.grid.voxels.z - 1};
  TestVolume coarse = volume;
  coarse.grid.voxels = {(last.x + 1) / 2 + 1, (last.y + 1) / 2 + 1, (last.z + 1) / 2 + 1};
  coarse.quantized_values.clear();
  const auto place = [](int32_t at, int32_t end) { return std::clamp(at, 0, end); };
  for (int32_t z = 0; z < coarse.grid.voxels.z; ++z) {
    for (int32_t y = 0; y < coarse.grid.voxels.y; ++y) {
      for (int32_t x = 0; x < coarse.grid.voxels.x; ++x) {
        uint32_t sum = 32;
        const int32_t x0 = place(2 * x, last.x), y0 = place(2 * y, last.y),
                      z0 = place(2 * z, last.z);
        for (int32_t i = 0; i < 27; ++i) {
          const int32_t dx = i % 3 - 1, dy = i / 3 % 3 - 1, dz = i / 9 - 1;
          const uint32_t value =
              volume.at(place(x0 + dx, last.x), place(y0 + dy, last.y), place(z0 + dz, last.z));
          sum += value << (3 - std::abs(dx) - std::abs(dy) - std::abs(dz));
        }
        coarse.quantized_values.push_back(static_cast<QuantizedValue>(sum >> 6));
      }
    }
  }
  return coarse;
}

/// The samples of a block that are active for some quantized isovalue in [low, high].
inline std::vector<PackedSample> block_samples(const TestVolume& volume, BlockKey block, double low,
                                               double high) {
  std::vector<PackedSample> samples;
  const LevelGrid level = level_grid(volume.grid.voxels, block.level);
  const Index3 cells = block_cells(level, block.index);
  const int32_t step = 1 << block.level;
  const Index3 n = volume.grid.voxels;
  TestVolume coarse;
  for (uint32_t i = 0; i < block.level; ++i) coarse = coarser_volume(i == 0 ? volume : coarse);
  const TestVolume& averages = block.level == 0 ? volume : coarse;
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      for (int32_t x = 0; x < cells.x; ++x) {
        const Index3 cell{block.index.x * kBlockCells + x, block.index.y * kBlockCells + y,
                          block.index.z * kBlockCells + z};
        const CellCorners corners = corners_at(averages, cell.x, cell.y, cell.z);
        const bool is_missing =
            volume.mapping.has_missing &&
            std::find(corners.begin(), corners.end(), kMissingVoxel) != corners.end();
        if (is_missing) continue;
        CellInterval interval = corner_interval(corners);
        if (step > 1) {
          interval = {65535, 0};
          for (int32_t k = cell.z * step; k <= std::min((cell.z + 1) * step, n.z - 1); ++k) {
            for (int32_t j = cell.y * step; j <= std::min((cell.y + 1) * step, n.y - 1); ++j) {
              for (int32_t i = cell.x * step; i <= std::min((cell.x + 1) * step, n.x - 1); ++i) {
                interval.min = std::min(interval.min, volume.at(i, j, k));
                interval.max = std::max(interval.max, volume.at(i, j, k));
              }
            }
          }
        }
        if (interval.min <= high && low < interval.max && interval.min < interval.max) {
          samples.push_back(pack_sample({x, y, z}, interval, corners));
        }
      }
    }
  }
  return samples;
}

/// Passes a level's chunks to the renderer and makes them visible. Returns the number of samples.
inline uint64_t show_volume(render::Renderer& renderer, const TestVolume& volume,
                            double isovalue_low, double isovalue_high, uint32_t level = 0,
                            render::VolumeId id = 0) {
  renderer.set_volume(volume.grid, volume.mapping, id);
  const LevelGrid grid = level_grid(volume.grid.voxels, level);
  std::vector<ChunkHandle> handles;
  uint64_t count = 0;
  for (int32_t z = 0; z < grid.blocks.z; ++z) {
    for (int32_t y = 0; y < grid.blocks.y; ++y) {
      for (int32_t x = 0; x < grid.blocks.x; ++x) {
        const BlockKey block{level, {x, y, z}};
        const auto samples =
            block_samples(volume, block, volume.mapping.quantized_isovalue(isovalue_low),
                          volume.mapping.quantized_isovalue(isovalue_high));
        const auto handle = static_cast<ChunkHandle>(handles.size());
        if (!renderer.add_chunk(handle, block, samples, id)) return 0;
        handles.push_back(handle);
        count += samples.size();
      }
    }
  }
  renderer.set_visible(handles, id);
  return count;
}

}  // namespace isosplat
