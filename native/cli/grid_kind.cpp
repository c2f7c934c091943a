#include "native/cli/grid_kind.h"

#include "shared/import/codecs/file_head.h"
#include "shared/import/vtk_amr/vtk_amr.h"
#include "shared/import/vtk_mesh/vtk_mesh.h"

namespace isosplat::cli {

GridKind grid_kind(const std::filesystem::path& path) {
  const auto head = import::read_head(path);
  if (!head) return GridKind::regular;
  if (import::is_vtk_amr(head->bytes())) return GridKind::adaptive;
  return import::is_vtk_mesh(*head) ? GridKind::unstructured : GridKind::regular;
}

}  // namespace isosplat::cli
