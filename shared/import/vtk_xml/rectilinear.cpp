#include "shared/import/vtk_xml/rectilinear.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/core/grid/grid.h"
#include "shared/import/vtk_xml/numbers.h"

namespace isosplat::import {
namespace {

/// Sets origin and spacing along an axis from positions. False if they are not evenly spaced.
bool place_axis(const std::vector<double>& positions, double& origin, double& spacing) {
  origin = positions.front();
  spacing = (positions.back() - origin) / static_cast<double>(positions.size() - 1);
  if (!std::isfinite(origin) || !std::isfinite(spacing) || spacing == 0) return false;
  for (size_t i = 0; i < positions.size(); ++i) {
    const double expected = origin + static_cast<double>(i) * spacing;
    // Positions are often 32-bit floats.
    if (!(std::abs(positions[i] - expected) <= 0.01 * std::abs(spacing))) return false;
  }
  return true;
}

}  // namespace

Result<VtkXmlAxes> vtk_xml_axes(const VtkXmlPieces& grid, const std::array<int64_t, 3>& points) {
  VtkXmlAxes axes;
  double* const origins[] = {&axes.origin.x, &axes.origin.y, &axes.origin.z};
  double* const spacings[] = {&axes.spacing.x, &axes.spacing.y, &axes.spacing.z};
  const VtkXmlExtent& whole = grid.main().whole;
  for (size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> all(static_cast<size_t>(points[axis]),
                            std::numeric_limits<double>::quiet_NaN());
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
      if (std::none_of(begin, end, [](double each) { return std::isnan(each); })) continue;
      const auto own =
          read_vtk_xml_numbers(file, piece.coordinates[axis], static_cast<uint64_t>(count));
      if (!own) return tl::unexpected(own.error());
      std::copy_n(own->begin() + offset(low, placed.used.low[axis]), end - begin, begin);
    }
    if (!place_axis(all, *origins[axis], *spacings[axis])) {
      axes.uneven = "xyz"[axis];
      return axes;
    }
    *origins[axis] -= *spacings[axis] * static_cast<double>(whole.low[axis]);
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
