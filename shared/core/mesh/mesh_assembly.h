#pragma once

#include <vector>

#include "shared/core/base/matrix3.h"
#include "shared/core/base/status.h"
#include "shared/core/grid/grid.h"
#include "shared/core/mesh/block_mesh.h"
#include "shared/core/mesh/edge_table.h"
#include "shared/core/mesh/mesh_part.h"

namespace isosplat {

/// The mesh of a block, and the block's low corner in cells of its level.
struct MeshedBlock {
  Index3 origin;
  BlockMesh mesh;
};

/// Joins the meshes of blocks to the mesh of a level: blocks share the vertices on their faces, and
/// vertices are numbered in the order of blocks. Holds at most two layers of blocks.
class MeshAssembly {
 public:
  MeshAssembly(const VolumeGrid& grid, uint32_t level);

  /// Adds all blocks of the next layer: those of one z, ascending by y and x; layers ascend by z.
  /// The layer before is then complete, since no later one shares its vertices. An empty layer
  /// completes the last one. Errors: out_of_memory (more than 2³² − 1 vertices).
  Result<void> add_layer(std::vector<MeshedBlock> blocks);

  /// How many parts the completed layer has: one for each of its blocks.
  size_t complete_parts() const { return complete_.blocks.size(); }

  /// Returns a part of the completed layer, in world space. Call it once for each part. Several
  /// threads may take different parts.
  MeshPart take_part(size_t i);

  /// Frees the completed layer. Call it before the next layer is meshed.
  void drop_complete() { complete_ = {}; }

  /// Counts of all layers that were added.
  MeshCounts counts() const { return counts_; }

 private:
  /// A vertex at the border of blocks: its number in the whole mesh, and the sum of its gradients
  /// so far.
  struct SharedVertex {
    uint32_t number = 0;
    Vec3f gradient;
  };
  /// A vertex of a block that an earlier block has as well, or that later ones may have.
  struct BorderNumber {
    uint32_t vertex = 0;  ///< in the block
    uint32_t shared = 0;  ///< index of its SharedVertex in the layer
    bool is_new = false;  ///< this block has it first
  };
  struct NumberedBlock {
    MeshedBlock block;
    std::vector<BorderNumber> border;
    uint32_t first_number = 0;  ///< of its new vertices, which are numbered in order
  };
  struct Layer {
    std::vector<NumberedBlock> blocks;
    std::vector<SharedVertex> shared;
    EdgeTable found;  ///< index in `shared`
  };

  void number(NumberedBlock& block, Layer& layer);

  const VolumeGrid grid_;
  const Matrix3d dual_edges_;
  const double cell_size_;  ///< of the level, in voxels
  const bool is_mirrored_;  ///< the volume's axes are left-handed in the world
  MeshCounts counts_;
  Layer complete_;
  Layer open_;  ///< the last one added
};

}  // namespace isosplat
