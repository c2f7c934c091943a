#pragma once

#include "shared/core/adaptive/adaptive_grid.h"
#include "shared/core/grid/grid.h"
#include "shared/core/unstructured/cell_bins.h"

namespace isosplat {

struct ResampleOptions {
  /// Grid cells are refined while the trilinear function differs more from the field of the mesh,
  /// in units of the values. 0: kDefaultErrorShare of the range of the values, but at least
  /// 10⁻¹² of the largest one.
  double max_error = 0;
  /// Limit, without the mesh.
  uint64_t memory_bytes = uint64_t{1} << 30;
};

inline constexpr double kDefaultErrorShare = 0.005;

/// Grid cells that are refined because of errors have edges of at least this share of the mesh's
/// cell there; those on the border of the mesh, at most kBorderShare.
inline constexpr double kFinestShare = 1.0 / 8;
inline constexpr double kBorderShare = 1.0 / 4;

/// An adaptive grid of an unstructured mesh.
struct ResampledMesh {
  AdaptiveGrid grid;     ///< with Centring::nodes; resolve() has been called
  VolumeGrid level_0;    ///< spacing and origin of the nodes of level 0; `voxels` is not set
  double max_error = 0;  ///< the limit that was used, in units of the values
};

/// Brings a mesh to an adaptive grid whose function is continuous and trilinear in each leaf cell.
///
/// The values at nodes are those of the mesh. Grid cells are refined by a ratio of 2 while their
/// edge is larger than size_of() a mesh cell in them, while they lie on the border of the mesh and
/// their edge is larger than kBorderShare of that size, and while the error is above the limit at
/// the mesh's points in the grid cell (at 64 corners of mesh cells at most, those of several cells
/// counted for each) or at 16 random points, down to kFinestShare of that size. Refinement ends at
/// kMostLatticeVoxels. A grid cell on the border is a
/// leaf if at least half of it is inside of the mesh; nodes outside then have the values of the
/// linear function that fits the inside best. If boundary faces that look at each other lie in it
/// or within 0.6 edges around it, there is a gap of the mesh, and it stays empty. Everything else
/// outside is empty. A grid cell whose centre is outside is on the border too, although all of its
/// corners are inside: holes of one cell stay empty. Oblique plates of the mesh that are thinner
/// than half of a leaf cell have none that is half inside, and vanish.
///
/// The same mesh has the same result on each machine. Errors: out_of_memory; malformed_volume if no
/// cell has values or a volume.
Result<ResampledMesh> resample(const UnstructuredMesh& mesh, const ResampleOptions& options);

/// The value of the grid's function at a point. Nothing where there is no leaf cell.
std::optional<double> value_at(const ResampledMesh& resampled, Vec3d point);

/// How the grid's function differs from the field of the mesh, at random points in its cells.
struct ResampleError {
  double max = 0, rms = 0;  ///< in units of the values
  double above = 0;         ///< the share of the points whose error is above the limit
  double outside = 0;       ///< the share of the mesh's volume that no leaf cell covers
  uint64_t points = 0;
};

/// Measures the error at up to 10^6 points: random ones, the same on each machine, in all cells of
/// the mesh with a size (UnstructuredMesh::size()) or in evenly chosen ones.
ResampleError measure_error(const UnstructuredMesh& mesh, const ResampledMesh& resampled);

/// Refinement ends where the lattice of the finest level, which builds of stores read, would have
/// more voxels. Level 0 may have more: up to 8 cells for each cell of the mesh.
inline constexpr uint64_t kMostLatticeVoxels = uint64_t{1} << 28;

}  // namespace isosplat
