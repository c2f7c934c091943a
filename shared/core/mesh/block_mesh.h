#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/mesh/cell_surface.h"
#include "shared/core/mesh/mesh_part.h"

namespace isosplat {

/// An edge of a level's lattice that the isosurface cuts: axis and low end, in cells of the level.
/// Identifies a vertex in all blocks.
struct LatticeEdge {
  Index3 low;
  int axis = 0;

  /// Different for all edges of a level, since it has at most 2^20 voxels along each axis.
  uint64_t key() const {
    return static_cast<uint64_t>(low.x) | static_cast<uint64_t>(low.y) << 21 |
           static_cast<uint64_t>(low.z) << 42 | uint64_t(axis) << 62;
  }
};

struct MeshVertex {
  Vec3f position;  ///< in cells, from the block's low corner
  /// The sum of the trilinear gradients of the block's cells at this point (x, y, z), in quantized
  /// values per cell. Only its direction counts. The sum over the four cells around a lattice edge
  /// is four times a gradient whose components across the edge are central differences. A vertex
  /// inside a cell has the gradient of this cell.
  std::array<float, 3> gradient_xyz;

  Vec3f gradient() const { return {gradient_xyz[0], gradient_xyz[1], gradient_xyz[2]}; }
};

/// A vertex on a face of its block, which other blocks may have as well.
struct BorderVertex {
  uint32_t vertex = 0;  ///< its index in the block
  LatticeEdge edge;     ///< in cells of the level
};

/// The isosurface in one block. Triangles are counter-clockwise seen from the side of lower values.
struct BlockMesh {
  std::vector<MeshVertex> vertices;
  std::vector<BorderVertex> border;  ///< ascending by vertex
  std::vector<std::array<uint32_t, 3>> triangles;
  FieldValues fields;  ///< at the vertices; BlockMesher leaves them to its caller
};

/// Makes triangles of decoded cells. Keeps scratch memory between calls, so use one per thread.
class BlockMesher {
 public:
  struct EdgeFrame;

  BlockMesher();

  /// Moves vertices that are nearer than `cells` to an end of their lattice edge away from it, so
  /// that no vertices of different edges coincide. Default: 0.
  void keep_off_lattice_points(float cells) { least_t_ = cells; }

  /// Replaces the content of `mesh`. origin: the block's low corner in cells of the level. cells:
  /// the cells of the block's chunk for this isovalue, in raster order as DecodedCells has them;
  /// inactive ones are skipped. Vertices are numbered by the order of cells.
  void run(const DecodedCells& cells, Index3 block_cells, Index3 origin, float quantized_isovalue,
           BlockMesh& mesh);

 private:
  /// The vertices on lattice edges whose low ends have one z. A table for all edges of a block
  /// takes 3 MB, more than an L2 cache has.
  struct EdgePlane {
    std::vector<uint32_t> vertex_of;  ///< of each edge, + 1; 0: none
    std::vector<uint32_t> used;       ///< entries of vertex_of that are not 0

    void clear();
  };

  void move_to(int32_t z);
  void add_cell(uint32_t cell, const CellCorners& corners, BlockMesh& mesh);
  uint32_t make_vertex(const EdgeFrame& edge, Index3 low, float t, BlockMesh& mesh);
  uint32_t vertex_at(const EdgeFrame& edge, Index3 low, uint32_t cell_entry,
                     const std::array<float, 8>& values, BlockMesh& mesh);

  Index3 cells_{}, origin_{};
  float isovalue_ = 0;
  float least_t_ = 0;  ///< of vertices: their distance from the ends of their edges
  std::array<const CellTriangles*, 256> simple_surfaces_{};  ///< by signs: see simple_cell_surface
  std::array<EdgePlane, 2> planes_;  ///< at the low and the high z of the current cells
  int32_t z_ = 0;                    ///< of the current cells
};

}  // namespace isosplat
