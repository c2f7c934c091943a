#include "shared/core/mesh_files/mesh_encoder.h"

#include "shared/core/mesh_files/glb_encoder.h"
#include "shared/core/mesh_files/ply_encoder.h"
#include "shared/core/mesh_files/stl_encoder.h"

namespace isosplat {

std::unique_ptr<MeshEncoder> make_mesh_encoder(MeshFormatId format, const VolumeGrid& grid,
                                               std::string_view comment) {
  switch (format) {
    case MeshFormatId::stl:
      return std::make_unique<StlEncoder>(comment);
    case MeshFormatId::ply:
      return std::make_unique<PlyEncoder>(grid, comment, PlyEncoder::Content::triangles);
    case MeshFormatId::glb:
      return std::make_unique<GlbEncoder>(grid, comment);
  }
  return nullptr;
}

}  // namespace isosplat
