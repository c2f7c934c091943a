#include "shared/import/vtk_xml/rectilinear.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "shared/core/grid/grid.h"
#include "shared/import/geometry/even_axis.h"
#include "shared/import/vtk_xml/numbers.h"

namespace isosplat::import {

Result<VtkXmlAxes> vtk_xml_axes(const VtkXmlPieces& grid, const std::array<int64_t, 3>& points) {
  VtkXmlAxes axes;
  double* const origins[] = {&axes.origin.x, &axes.origin.y, &axes.origin.z};
  double* const spacings[] = {&axes.spacing.x, &axes.spacing.y, &axes.spacing.z};
  const VtkXmlExtent& whole = grid.main().whole;
  for (size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> all(static_cast<size_t>(points[axis]),
                            std::numeric_limits<double>::quiet_NaN());
    std::vector<bool> is_known(all.size());
    for (const VtkXmlPlaced& placed : grid.placed) {
      const VtkXmlPiece& piece = grid.piece(placed);
      const VtkXmlFile& file = grid.files[placed.file];
      const int64_t low = piece.extent.low[axis], count = piece.extent.high[axis] - low + 1;
      if (piece.coordinates.size() != 3 || !piece.coordinates[axis].type ||
          count > kMaxVoxelsPerAxis) {
        return malformed_vtk_xml(file.path, "expected <Coordinates> of x, y and z");
      }
      // Pieces beside each other have the same positions along the other axes.
      const auto offset = [](int64_t from, int64_t to) {
        return static_cast<std::ptrdiff_t>(to - from);
      };
      const auto begin = all.begin() + offset(whole.low[axis], placed.used.low[axis]);
      const auto end = all.begin() + offset(whole.low[axis], placed.used.high[axis] + 1);
      const auto first = is_known.begin() + (begin - all.begin());
      if (std::find(first, first + (end - begin), false) == first + (end - begin)) continue;
      std::fill_n(first, end - begin, true);
      const auto own =
          read_vtk_xml_numbers(file, piece.coordinates[axis], static_cast<uint64_t>(count));
      if (!own) return tl::unexpected(own.error());
      std::copy_n(own->begin() + offset(low, placed.used.low[axis]), end - begin, begin);
    }
    const auto missing = std::find(is_known.begin(), is_known.end(), false);
    if (missing != is_known.end()) {
      return malformed_vtk_xml(grid.main().path, "expected positions of all " +
                                                     std::to_string(all.size()) + " points along " +
                                                     "xyz"[axis] + ", found none of point " +
                                                     std::to_string(missing - is_known.begin()));
    }
    const auto even = even_axis(all);
    if (!even) {
      axes.uneven = "xyz"[axis];
      return axes;
    }
    *spacings[axis] = even->spacing;
    *origins[axis] = even->origin - even->spacing * static_cast<double>(whole.low[axis]);
  }
  return axes;
}

std::array<int64_t, 3> vtk_xml_points(const VtkXmlFile& file) {
  std::array<int64_t, 3> points{};
  for (size_t axis = 0; axis < 3; ++axis) {
    points[axis] = file.whole.high[axis] - file.whole.low[axis] + 1;
  }
  return points;
}

bool is_uneven_vtk_xml(const std::filesystem::path& path) {
  const auto grid = read_vtk_xml_pieces(path);
  if (!grid || grid->main().grid != VtkXmlGrid::rectilinear || grid->placed.empty()) return false;
  const auto points = vtk_xml_points(grid->main());
  for (const int64_t each : points) {
    if (each < 2 || each > kMaxVoxelsPerAxis) return false;
  }
  const auto axes = vtk_xml_axes(*grid, points);
  return axes && axes->uneven != 0;
}

}  // namespace isosplat::import
