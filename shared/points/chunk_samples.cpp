#include "shared/points/chunk_samples.h"

#include <cmath>

#include "shared/sampling/exact_projection.h"
#include "shared/sampling/projection.h"
#include "shared/sampling/sample.h"

namespace isosplat {
namespace {

Vec3d as_double(Vec3f v) {
  return {v.x, v.y, v.z};
}

Vec3f as_float(Vec3d v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// The way from a block's cells to level-0 voxel units.
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

PointArrays project_samples(const DecodedCells& cells, const ChunkFrame& frame, float isocode,
                            bool exact) {
  const CellFrame cell_frame(frame.block);
  const VolumeGrid& grid = *frame.grid;
  const Vec3f size = as_float(grid.spacing * cell_frame.cell);
  const float threshold = displacement_threshold(size);
  PointArrays result;
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    if (!is_active(cells.interval[i], isocode)) continue;
    const Trilinear field(cells.corners[i]);
    const Sample sample = centre_sample(cells.corners[i], cells.interval[i]);
    // The step is found in the cell's own frame, scaled to the proportions of the world.
    const Vec3f gradient{sample.gradient.x / size.x, sample.gradient.y / size.y,
                         sample.gradient.z / size.z};
    const Vec3f direction{gradient.x / size.x, gradient.y / size.y, gradient.z / size.z};
    Vec3f in_cell = sample.position;
    std::optional<Vec3f> met;
    if (exact) {
      met = project_exactly(field, sample.position, direction, isocode);
    }
    if (met) {
      in_cell = *met;
    } else {
      const auto step = project({0, 0, 0}, sample.value, gradient, isocode);
      if (!step) {
        if (frame.block.level == 0) continue;
      } else {
        const float distance = length(*step);
        float scale = 1;
        if (distance > threshold) {
          if (frame.block.level == 0) continue;
          scale = threshold / distance;
        }
        in_cell = in_cell + Vec3f{step->x / size.x, step->y / size.y, step->z / size.z} * scale;
      }
    }
    const Vec3d index = cell_frame.index(cells.cell[i], as_double(in_cell));
    result.positions.push_back(grid.world(index));
    const Vec3f at_point = met ? field.at(*met).gradient : sample.gradient;
    const Vec3d world_gradient = grid.world_gradient(as_double(at_point));
    const double steepness = length(world_gradient);
    result.normals.push_back(as_float(world_gradient * (steepness > 0 ? -1 / steepness : 0.0)));
  }
  return result;
}

}  // namespace isosplat
