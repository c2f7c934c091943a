#include "shared/import/vtk_xml/vtk_xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <utility>

#include "shared/import/geometry/conventions.h"
#include "shared/import/volume/choose_array.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/vtk_xml/array_bytes.h"
#include "shared/import/vtk_xml/choose.h"
#include "shared/import/vtk_xml/parts.h"
#include "shared/import/vtk_xml/rectilinear.h"

// Reads images of VTK's XML format: selects an array, and joins its pieces.
namespace isosplat::import {
namespace {

/// The part of the volume that a piece has. `chosen`: an array of the first piece; the others have
/// one of its name.
Result<VtkXmlPart> part_of(const VtkXmlPieces& grid, const VtkXmlPlaced& placed,
                           const VtkXmlArray& chosen, size_t index) {
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
  const VtkXmlFile& first = grid.files[grid.placed.front().file];
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

}  // namespace

bool is_vtk_xml(std::string_view beginning) {
  const std::string type = vtk_xml_type(beginning);
  const std::string_view plain = std::string_view(type).substr(type.starts_with('P') ? 1 : 0);
  return plain == "ImageData" || plain == "RectilinearGrid";
}

Result<OpenVolume> open_vtk_xml(const std::filesystem::path& path, const ImportOptions& options) {
  auto grid = read_vtk_xml_pieces(path);
  if (!grid) return tl::unexpected(grid.error());
  if (grid->placed.empty()) {
    return malformed_vtk_xml(path, "expected a <Piece> inside the WholeExtent, found none");
  }
  std::vector<std::string> notes;
  const auto chosen =
      choose_vtk_xml_array(grid->main(), grid->piece(grid->placed.front()).arrays, options, notes);
  if (!chosen) return tl::unexpected(chosen.error());
  if (const auto step = choose_step(path, 1, options); !step) return tl::unexpected(step.error());
  const VtkXmlArray array = grid->piece(grid->placed.front()).arrays[chosen->array];

  const VtkXmlFile& main = grid->main();
  const std::array<int64_t, 3> points = vtk_xml_points(main);
  const int64_t fewer = array.of_cells ? 1 : 0;
  const Vec3<int64_t> sizes{points[0] - fewer, points[1] - fewer, points[2] - fewer};
  // Checked before memory is allocated for positions.
  if (const auto fits = orient(sizes, {}); !fits) {
    return fail(fits.error().status, path.string() + ": " + fits.error().message);
  }
  Vec3d origin = main.origin, spacing = main.spacing.value_or(Vec3d{1, 1, 1});
  const bool is_rectilinear = main.grid == VtkXmlGrid::rectilinear;
  if (is_rectilinear) {
    const auto axes = vtk_xml_axes(*grid, points);
    if (!axes) return tl::unexpected(axes.error());
    if (axes->uneven != 0) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected evenly spaced coordinates along {}, found others: "
                              "isosplat build makes a scene of this grid; for a volume, resample "
                              "it to an image (in ParaView: Resample To Image), and save that",
                              path.string(), axes->uneven));
    }
    origin = axes->origin;
    spacing = axes->spacing;
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
    direction = grid->files[grid->placed.front().file].direction;
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
  for (const VtkXmlPlaced& placed : grid->placed) {
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
