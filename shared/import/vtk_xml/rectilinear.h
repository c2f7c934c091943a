#pragma once

#include "shared/import/vtk_xml/pieces.h"

namespace isosplat::import {

/// The origin of index 0 and the spacing of a rectilinear grid with even spacing.
struct VtkXmlAxes {
  Vec3d origin{0, 0, 0}, spacing{1, 1, 1};
  char uneven = 0;  ///< the first axis with other positions: x, y or z; 0: none
};

/// Compares the positions along the axes with evenly spaced ones, up to 0.01 of the spacing.
/// `points`: those along each axis, of which memory is allocated. Errors: those of
/// read_vtk_xml_numbers; malformed_volume without arrays of positions.
Result<VtkXmlAxes> vtk_xml_axes(const VtkXmlPieces& grid, const std::array<int64_t, 3>& points);

/// The points along each axis of the whole extent.
std::array<int64_t, 3> vtk_xml_points(const VtkXmlFile& file);

/// Whether a file is a rectilinear grid whose positions can be read, are at least two along each
/// axis, and are not evenly spaced along one of them.
bool is_uneven_vtk_xml(const std::filesystem::path& path);

}  // namespace isosplat::import
