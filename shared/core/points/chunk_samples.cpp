#include "shared/core/points/chunk_samples.h"

#include <algorithm>
#include <cmath>

#include "shared/core/sampling/exact_projection.h"
#include "shared/core/sampling/projection.h"
#include "shared/core/sampling/sample.h"

namespace isosplat {
namespace {

Vec3d as_double(Vec3f v) {
  return {v.x, v.y, v.z};
}

Vec3f as_float(Vec3d v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

Vec3f clamped_to_cell(Vec3f p) {
  return {std::clamp(p.x, 0.0f, 1.0f), std::clamp(p.y, 0.0f, 1.0f), std::clamp(p.z, 0.0f, 1.0f)};
}

/// Converts cells of a block to level-0 voxel units.
struct CellFrame {
  double cell;  ///< voxels of level 0 along a cell
  Vec3d first;  ///< the block's first cell, in cells of its level

  explicit CellFrame(BlockKey block)
      : cell(std::ldexp(1.0, static_cast<int>(block.level))),
        first{static_cast<double>(block.index.x) * kBlockCells,
              static_cast<double>(block.index.y) * kBlockCells,
              static_cast<double>(block.index.z) * kBlockCells} {}

  Vec3d index(uint32_t packed_cell, Vec3d in_cell) const {
    const Vec3d corner{static_cast<double>(packed_cell & 63),
                       static_cast<double>(packed_cell >> 6 & 63),
                       static_cast<double>(packed_cell >> 12 & 63)};
    return (first + corner + in_cell) * cell;
  }
};

}  // namespace

DecodedCells cells_of(std::span<const PackedSample> samples, const RegionMask& regions) {
  DecodedCells cells;
  for (const PackedSample& packed : samples) {
    const UnpackedSample sample = unpack_sample(packed);
    const Index3 at = sample.cell;
    constexpr int32_t kRegionCells = kBlockCells / kBlockRegions;
    if (!regions.contains({at.x / kRegionCells, at.y / kRegionCells, at.z / kRegionCells}))
      continue;
    cells.cell.push_back(static_cast<uint32_t>(at.x | at.y << 6 | at.z << 12));
    cells.interval.push_back(sample.interval);
    CellCorners& corners = cells.corners.emplace_back();
    // Corners are integers. Those of invalid samples may exceed the largest quantized value.
    std::transform(sample.corners.begin(), sample.corners.end(), corners.begin(), [](float corner) {
      return static_cast<QuantizedValue>(std::min(corner, 65535.0f));
    });
  }
  return cells;
}

SampleArrays samples_of(const DecodedCells& cells, const ChunkFrame& frame) {
  const CellFrame cell_frame(frame.block);
  SampleArrays result;
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    const Sample sample = centre_sample(cells.corners[i], cells.interval[i]);
    const Vec3d index = cell_frame.index(cells.cell[i], as_double(sample.position));
    result.positions.push_back(as_float(frame.grid->world(index)));
    result.values.push_back(static_cast<float>(frame.mapping->value(sample.value)));
    const Vec3d gradient =
        frame.grid->world_gradient(as_double(sample.gradient) * (1 / cell_frame.cell));
    result.gradients.push_back(as_float(gradient * frame.mapping->scale));
    result.intervals.push_back({static_cast<float>(frame.mapping->value(sample.interval.min)),
                                static_cast<float>(frame.mapping->value(sample.interval.max))});
  }
  return result;
}

PointArrays project_samples(const DecodedCells& cells, const ChunkFrame& frame,
                            float quantized_isovalue, const ProjectionOptions& options,
                            const LatticeGradients* smooth_gradients,
                            std::vector<PointPlace>* places) {
  const CellFrame cell_frame(frame.block);
  const VolumeGrid& grid = *frame.grid;
  // Computes the step in the world, relative to the cell's centre, and converts it to cell units.
  const Matrix3d dual = grid.dual_edges();
  const double per_cell = 1 / cell_frame.cell;
  const auto world_gradient = [&](Vec3f g) { return multiply(dual, as_double(g) * per_cell); };
  const auto in_cells = [&](Vec3d v) { return as_float(multiply_transposed(dual, v) * per_cell); };
  const auto threshold =
      static_cast<float>(displacement_threshold(grid.cell_edges()) * cell_frame.cell);
  const bool drops = options.displaced == Displaced::drop && frame.block.level == 0;
  PointArrays result;
  const auto most = static_cast<size_t>(std::count_if(
      cells.interval.begin(), cells.interval.end(),
      [&](const CellInterval& interval) { return is_active(interval, quantized_isovalue); }));
  result.positions.reserve(most);
  result.normals.reserve(most);
  if (options.values) result.values.reserve(most);
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    if (!is_active(cells.interval[i], quantized_isovalue)) continue;
    const Trilinear field(cells.corners[i]);
    const Sample sample = centre_sample(cells.corners[i], cells.interval[i]);
    // The interval of a coarse cell may exceed the range of its corners.
    const CellInterval reached = corner_interval(cells.corners[i]);
    const float target = std::clamp(quantized_isovalue, static_cast<float>(reached.min),
                                    static_cast<float>(reached.max));
    const Vec3d gradient = world_gradient(sample.gradient);
    Vec3f in_cell = sample.position, at_gradient = sample.gradient;
    std::optional<Vec3f> met;
    if (options.exact) met = project_exactly(field, in_cell, in_cells(gradient), target);
    if (met) {
      in_cell = *met;
      at_gradient = field.at(in_cell).gradient;
    } else if (const auto step = project({0, 0, 0}, sample.value, as_float(gradient), target)) {
      const float distance = length(*step);
      if (drops && distance > threshold) continue;
      const float scale = distance > threshold ? threshold / distance : 1;
      in_cell = in_cell + in_cells(as_double(*step * scale));
      if (!drops) in_cell = clamped_to_cell(in_cell);
    } else if (drops) {
      continue;
    }
    const Vec3d index = cell_frame.index(cells.cell[i], as_double(in_cell));
    result.positions.push_back(grid.world(index));
    if (places) places->push_back({cells.cell[i], in_cell});
    if (options.values) {
      result.values.push_back(static_cast<float>(frame.mapping->value(field.at(in_cell).value)));
    }
    if (smooth_gradients) {
      // A point outside of its cell has the normal of the nearest point in the cell, since the sums
      // for the cells beyond the block's border are not available.
      const Vec3f sum = smooth_gradients->at(cells.cell[i], clamped_to_cell(in_cell));
      if (dot(sum, sum) > 0) at_gradient = sum;
    }
    const Vec3d normal = world_gradient(at_gradient);
    const double steepness = length(normal);
    result.normals.push_back(as_float(normal * (steepness > 0 ? -1 / steepness : 0.0)));
  }
  return result;
}

}  // namespace isosplat
