#include "shared/import/vtk_xml/pieces.h"

#include <algorithm>
#include <utility>

namespace isosplat::import {
namespace {

VtkXmlExtent common(const VtkXmlExtent& a, const VtkXmlExtent& b) {
  VtkXmlExtent both;
  for (size_t axis = 0; axis < 3; ++axis) {
    both.low[axis] = std::max(a.low[axis], b.low[axis]);
    both.high[axis] = std::min(a.high[axis], b.high[axis]);
  }
  return both;
}

}  // namespace

Result<VtkXmlPieces> read_vtk_xml_pieces(const std::filesystem::path& path) {
  VtkXmlPieces grid;
  auto main = read_vtk_xml(path);
  if (!main) return tl::unexpected(main.error());
  grid.files.push_back(std::move(*main));
  const VtkXmlExtent whole = grid.main().whole;
  const size_t pieces = grid.main().pieces.size();
  for (size_t i = 0; i < pieces; ++i) {
    const VtkXmlExtent extent = common(grid.main().pieces[i].extent, whole);
    if (!grid.main().is_parallel) {
      grid.placed.push_back({0, i, extent});
      continue;
    }
    const std::filesystem::path source = path.parent_path() / grid.main().pieces[i].source;
    auto file = read_vtk_xml(source);
    if (!file) return tl::unexpected(file.error());
    if (file->is_parallel || file->grid != grid.main().grid) {
      return malformed_vtk_xml(source, "expected a piece with the type of the file that names it");
    }
    for (size_t k = 0; k < file->pieces.size(); ++k) {
      grid.placed.push_back({grid.files.size(), k, common(extent, file->pieces[k].extent)});
    }
    grid.files.push_back(std::move(*file));
  }
  std::erase_if(grid.placed, [](const VtkXmlPlaced& placed) { return placed.used.is_empty(); });
  return grid;
}

}  // namespace isosplat::import
