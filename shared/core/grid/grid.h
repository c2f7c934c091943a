#pragma once

#include <cstdint>
#include <string>

#include "shared/core/base/matrix3.h"
#include "shared/core/base/vec3.h"

namespace isosplat {

/// A voxel as the store holds it: an index into evenly spaced values.
using QuantizedValue = uint16_t;

/// Marks a voxel without a value (NaN, infinity), only if ValueMapping::has_missing.
inline constexpr QuantizedValue kMissingVoxel = 65535;

/// Maps quantized values to the volume's values: value = offset + scale · quantized value.
///
/// Everything between the store and the GPU works on quantized values; quantized_isovalue()
/// converts an isovalue once. Integers with any slope and intercept, and evenly spaced
/// floating-point numbers, are stored without loss if 16 bits suffice; other values with an error
/// of at most max_error.
struct ValueMapping {
  double offset = 0;
  double scale = 1;          ///< above 0: greater quantized values are greater values
  double max_error = 0;      ///< in value units; 0: lossless
  uint8_t bits = 16;         ///< 8: all quantized values are < 256; otherwise 16
  bool has_missing = false;  ///< kMissingVoxel marks voxels without a value

  double value(double quantized) const { return offset + scale * quantized; }

  /// The isovalue on the scale of quantized values, in single precision. The CPU and the GPU
  /// compare quantized values with it. For every quantized value q: q ≤ quantized_isovalue(v) if
  /// and only if value(q) ≤ v, and q = quantized_isovalue(v) if and only if value(q) and v are the
  /// same number. Values were rounded in the file, and isovalues by the user. Therefore two numbers
  /// count as the same if they are equal in single precision (provided that this distinguishes
  /// neighbouring quantized values), or equal up to the rounding error of value(). NaN for NaN.
  float quantized_isovalue(double isovalue) const;
};

/// The positions of a volume's voxels: world = origin + direction · (spacing ∘ index), in the units
/// of the file's header (millimetres for medical images, in LPS orientation). The axes need not be
/// perpendicular: a CT with gantry tilt has a sheared grid.
struct VolumeGrid {
  Index3 voxels;                    ///< voxels along each axis, ≥ 2
  Vec3d spacing{1, 1, 1};           ///< > 0; the distance between neighbours along each axis
  Vec3d origin{0, 0, 0};            ///< the centre of voxel (0, 0, 0)
  Matrix3d direction = kIdentity3;  ///< its columns are the axes in the world; is_basis() holds

  /// The world position of a point given in level-0 voxel units.
  Vec3d world(Vec3d index) const;

  /// A gradient with respect to world position, from one with respect to voxel index.
  Vec3d world_gradient(Vec3d index_gradient) const;

  /// direction · diag(spacing): its columns are the edges of a cell of level 0.
  Matrix3d cell_edges() const { return scale_columns(direction, spacing); }

  /// The transposed inverse of cell_edges(). It maps a gradient with respect to voxel index to the
  /// gradient in the world. Its transpose maps a vector in the world to the vector in voxels.
  Matrix3d dual_edges() const {
    return scale_columns(inverse_transpose(direction),
                         {1 / spacing.x, 1 / spacing.y, 1 / spacing.z});
  }
};

/// Whether the columns are of unit length (to within 10⁻⁶) and do not lie nearly in one plane:
/// |determinant| ≥ 10⁻³. If a grid is sheared in one plane, this means an angle of at least 0.06°
/// between its axes. Instruments are far from this limit, and single precision could not represent
/// flatter cells.
bool is_basis(const Matrix3d& direction);

/// The largest difference of an angle between two columns from 90°, in degrees. The columns may
/// have any length. The rounding of headers in single precision amounts to some 10⁻⁵ degrees.
double shear_degrees(const Matrix3d& axes);

/// Below this, axes count as perpendicular, without a note.
inline constexpr double kMinShearDegrees = 0.01;

/// Cells along each axis of a block, at every level.
inline constexpr int32_t kBlockCells = 64;

/// The coarsest level is the first whose longest axis has at most this many cells.
inline constexpr int32_t kCoarsestCells = 16;

/// The most voxels along an axis, so that every index fits in 32 bits with a margin.
inline constexpr int32_t kMaxVoxelsPerAxis = 1 << 20;

/// The cells and blocks of one level. Level 0 is the volume. A cell of level l covers 2^l cells of
/// level 0 along each axis; where the volume's cell count is not a multiple of that, the last cell
/// reaches beyond the volume, whose last voxel is repeated there.
struct LevelGrid {
  uint32_t level = 0;
  Index3 cells;   ///< along each axis, ≥ 1; there is one more voxel than cells
  Index3 blocks;  ///< along each axis: ⌈cells / kBlockCells⌉

  uint64_t block_count() const {
    return static_cast<uint64_t>(blocks.x) * static_cast<uint64_t>(blocks.y) *
           static_cast<uint64_t>(blocks.z);
  }
};

/// The number of levels of a volume, ≥ 1.
uint32_t level_count(Index3 voxels);

/// The given level of a volume with these voxels. Requires level < level_count(voxels).
LevelGrid level_grid(Index3 voxels, uint32_t level);

/// Identifies a block: its level, and its index along each axis in blocks of that level.
struct BlockKey {
  uint32_t level = 0;
  Index3 index;

  friend constexpr bool operator==(const BlockKey&, const BlockKey&) = default;
};

/// "0/1.2.3": level and index. How messages, URLs and the command line name a block.
std::string block_name(BlockKey block);

/// "0/1.2.3/4": block and band.
std::string chunk_name(BlockKey block, uint32_t band);

/// The cells of a block along each axis: kBlockCells, or fewer in the last block of an axis.
Index3 block_cells(const LevelGrid& level, Index3 block);

}  // namespace isosplat
