#include "shared/import/vtk_xml/vtk_xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "shared/import/geometry/conventions.h"
#include "shared/import/volume/choose_array.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/vtk_xml/array_bytes.h"
#include "shared/import/vtk_xml/choose.h"
#include "shared/import/vtk_xml/numbers.h"
#include "shared/import/vtk_xml/parts.h"

// Reads images of VTK's XML format: selects an array, and joins its pieces.
namespace isosplat::import {
namespace {

/// A piece of the grid, with the extent for which it is read.
struct Placed {
  size_t file = 0, piece = 0;  ///< indices in Grid::files and VtkXmlFile::pieces
  VtkXmlExtent used;
};

struct Grid {
  std::vector<VtkXmlFile> files;  ///< the opened file, and those of its pieces
  std::vector<Placed> pieces;

  const VtkXmlFile& main() const { return files.front(); }
  const VtkXmlPiece& piece(const Placed& placed) const {
    return files[placed.file].pieces[placed.piece];
  }
};

VtkXmlExtent common(const VtkXmlExtent& a, const VtkXmlExtent& b) {
  VtkXmlExtent both;
  for (size_t axis = 0; axis < 3; ++axis) {
    both.low[axis] = std::max(a.low[axis], b.low[axis]);
    both.high[axis] = std::min(a.high[axis], b.high[axis]);
  }
  return both;
}

/// Reads the file, and the files of its pieces. Ghost levels of a piece's file, outside of the
/// piece's extent, are not read.
Result<Grid> read_grid(const std::filesystem::path& path) {
  Grid grid;
  auto main = read_vtk_xml(path);
  if (!main) return tl::unexpected(main.error());
  grid.files.push_back(std::move(*main));
  const VtkXmlExtent whole = grid.main().whole;
  const size_t pieces = grid.main().pieces.size();
  for (size_t i = 0; i < pieces; ++i) {
    const VtkXmlExtent extent = common(grid.main().pieces[i].extent, whole);
    if (!grid.main().is_parallel) {
      grid.pieces.push_back({0, i, extent});
      continue;
    }
    const std::filesystem::path source = path.parent_path() / grid.main().pieces[i].source;
    auto file = read_vtk_xml(source);
    if (!file) return tl::unexpected(file.error());
    if (file->is_parallel || file->grid != grid.main().grid) {
      return malformed_vtk_xml(source, "expected a piece with the type of the file that names it");
    }
    for (size_t k = 0; k < file->pieces.size(); ++k) {
      grid.pieces.push_back({grid.files.size(), k, common(extent, file->pieces[k].extent)});
    }
    grid.files.push_back(std::move(*file));
  }
  std::erase_if(grid.pieces, [](const Placed& placed) { return placed.used.is_empty(); });
  if (grid.pieces.empty()) {
    return malformed_vtk_xml(path, "expected a <Piece> inside the WholeExtent, found none");
  }
  return grid;
}

/// The part of the volume that a piece has. `chosen`: an array of the first piece; the others have
/// one of its name.
Result<VtkXmlPart> part_of(const Grid& grid, const Placed& placed, const VtkXmlArray& chosen,
                           size_t index) {
  const VtkXmlPiece& piece = grid.piece(placed);
  const VtkXmlFile& file = grid.files[placed.file];
  const auto is_it = [&](const VtkXmlArray& array) {
    return array.name == chosen.name && array.of_cells == chosen.of_cells;
  };
  auto array = std::find_if(piece.arrays.begin(), piece.arrays.end(), is_it);
  if (index < piece.arrays.size() && is_it(piece.arrays[index])) {
    array = piece.arrays.begin() + static_cast<std::ptrdiff_t>(index);
  }
  const auto is_swapped = [&](const VtkXmlArray& each, const VtkXmlFile& of) {
    return each.format != VtkXmlArray::Format::ascii && of.big_endian;
  };
  const VtkXmlFile& first = grid.files[grid.pieces.front().file];
  if (array == piece.arrays.end() || array->type != chosen.type ||
      array->components != chosen.components ||
      is_swapped(*array, file) != is_swapped(chosen, first)) {
    return malformed_vtk_xml(file.path,
                             fmt::format("expected the array '{}' in each piece, with the same "
                                         "type, components and byte order",
                                         chosen.name));
  }
  VtkXmlPart part;
  part.file = placed.file;
  part.array = *array;
  const int64_t more = chosen.of_cells ? 0 : 1;
  for (size_t axis = 0; axis < 3; ++axis) {
    const int64_t origin = grid.main().whole.low[axis];
    part.low[axis] = placed.used.low[axis] - origin;
    part.high[axis] = placed.used.high[axis] - origin + more;
    part.stored_low[axis] = piece.extent.low[axis] - origin;
    part.stored[axis] = piece.extent.high[axis] - piece.extent.low[axis] + more;
  }
  return part;
}

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

/// Sets the origin of index 0 and the spacing of a rectilinear grid. Errors: unsupported_format for
/// uneven ones, and those of coordinates_of.
Result<void> place_rectilinear(const Grid& grid, const std::array<int64_t, 3>& points,
                               Vec3d& origin, Vec3d& spacing) {
  double* const origins[] = {&origin.x, &origin.y, &origin.z};
  double* const spacings[] = {&spacing.x, &spacing.y, &spacing.z};
  const VtkXmlExtent& whole = grid.main().whole;
  for (size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> all(static_cast<size_t>(points[axis]),
                            std::numeric_limits<double>::quiet_NaN());
    for (const Placed& placed : grid.pieces) {
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
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected evenly spaced coordinates along {}, found others: "
                              "resample the grid to an image (in ParaView: Resample To Image), and "
                              "save that",
                              grid.main().path.string(), "xyz"[axis]));
    }
    *origins[axis] -= *spacings[axis] * static_cast<double>(whole.low[axis]);
  }
  return {};
}

}  // namespace

bool is_vtk_xml(std::string_view beginning) {
  const std::string type = vtk_xml_type(beginning);
  const std::string_view plain = std::string_view(type).substr(type.starts_with('P') ? 1 : 0);
  return plain == "ImageData" || plain == "RectilinearGrid";
}

Result<OpenVolume> open_vtk_xml(const std::filesystem::path& path, const ImportOptions& options) {
  auto grid = read_grid(path);
  if (!grid) return tl::unexpected(grid.error());
  std::vector<std::string> notes;
  const auto chosen =
      choose_vtk_xml_array(grid->main(), grid->piece(grid->pieces.front()).arrays, options, notes);
  if (!chosen) return tl::unexpected(chosen.error());
  if (const auto step = choose_step(path, 1, options); !step) return tl::unexpected(step.error());
  const VtkXmlArray array = grid->piece(grid->pieces.front()).arrays[chosen->array];

  const VtkXmlFile& main = grid->main();
  std::array<int64_t, 3> points{};
  for (size_t axis = 0; axis < 3; ++axis) {
    points[axis] = main.whole.high[axis] - main.whole.low[axis] + 1;
  }
  const int64_t fewer = array.of_cells ? 1 : 0;
  const Vec3<int64_t> sizes{points[0] - fewer, points[1] - fewer, points[2] - fewer};
  // Checked before memory is allocated for positions.
  if (const auto fits = orient(sizes, {}); !fits) {
    return fail(fits.error().status, path.string() + ": " + fits.error().message);
  }
  Vec3d origin = main.origin, spacing = main.spacing.value_or(Vec3d{1, 1, 1});
  const bool is_rectilinear = main.grid == VtkXmlGrid::rectilinear;
  if (is_rectilinear) {
    if (auto placed = place_rectilinear(*grid, points, origin, spacing); !placed) {
      return tl::unexpected(placed.error());
    }
  } else if (!main.spacing) {
    notes.push_back("the header has no voxel spacing: 1,1,1 is assumed; --spacing sets another");
  }
  for (const double each : {spacing.x, spacing.y, spacing.z}) {
    if (each < 0)
      notes.push_back(fmt::format("the spacing {} is negative: the axis is reversed", each));
  }
  const double shift = array.of_cells ? 0.5 : 0;
  if (array.of_cells) {
    notes.push_back("the values belong to cells: each becomes a voxel at its cell's centre");
  }
  std::optional<Matrix3d> direction = main.direction;
  if (!direction && main.is_parallel && !is_rectilinear) {
    // VTK 9.1 writes no Direction into files that name others.
    direction = grid->files[grid->pieces.front().file].direction;
    if (direction && *direction != kIdentity3) {
      notes.push_back("the file has no Direction: that of its first piece is used");
    }
  }
  const Matrix3d edges = scale_columns(direction.value_or(kIdentity3), spacing);
  const auto& low = main.whole.low;
  const Vec3d first =
      multiply(edges, {static_cast<double>(low[0]) + shift, static_cast<double>(low[1]) + shift,
                       static_cast<double>(low[2]) + shift});
  const HeaderGeometry geometry =
      geometry_of_steps({column(edges, 0), column(edges, 1), column(edges, 2)}, origin + first);

  std::vector<VtkXmlPart> parts;
  for (const Placed& placed : grid->pieces) {
    auto part = part_of(*grid, placed, array, chosen->array);
    if (!part) return tl::unexpected(part.error());
    parts.push_back(std::move(*part));
  }
  ArrayVolume volume = make_array("VTK XML", path, sizes, geometry, options);
  volume.step_axis = 0;
  volume.steps = static_cast<uint64_t>(array.components);
  volume.step = chosen->component;
  volume.stored.type = *array.type;
  const bool is_text = array.format == VtkXmlArray::Format::ascii;
  volume.stored.big_endian = is_text ? std::endian::native == std::endian::big
                                     : grid->files[parts.front().file].big_endian;
  auto bytes = open_vtk_xml_parts(std::move(grid->files), std::move(parts), sizes);
  if (!bytes) return tl::unexpected(bytes.error());
  // The number of values in text form has been checked; their reader knows an upper bound only.
  volume.ends_with_file = false;
  return open_array(std::move(volume), std::move(*bytes), std::move(notes));
}

}  // namespace isosplat::import
