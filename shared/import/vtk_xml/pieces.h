#pragma once

#include <vector>

#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// A piece of the grid, with the extent for which it is read.
struct VtkXmlPlaced {
  size_t file = 0, piece = 0;  ///< indices in VtkXmlPieces::files and VtkXmlFile::pieces
  VtkXmlExtent used;           ///< not of unstructured grids
};

/// A file and those of its pieces, without their values.
struct VtkXmlPieces {
  std::vector<VtkXmlFile> files;  ///< the opened file first
  std::vector<VtkXmlPlaced> placed;

  const VtkXmlFile& main() const { return files.front(); }
  const VtkXmlPiece& piece(const VtkXmlPlaced& of) const { return files[of.file].pieces[of.piece]; }
};

/// Reads a file, and the files of its pieces. Ghost levels of a piece's file, outside of the
/// piece's extent, are not used; pieces of which nothing is used are left out. Errors: those of
/// read_vtk_xml; malformed_volume for pieces of another type.
Result<VtkXmlPieces> read_vtk_xml_pieces(const std::filesystem::path& path);

}  // namespace isosplat::import
