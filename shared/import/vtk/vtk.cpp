#include "shared/import/vtk/vtk.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "shared/import/geometry/conventions.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_array.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/text_voxels.h"
#include "shared/import/vtk/axes.h"
#include "shared/import/vtk/sections.h"

// Reads legacy VTK files with structured points or evenly spaced coordinates: selects the array of
// scalars and checks its size.
namespace isosplat::import {
namespace {

tl::unexpected<Error> malformed(const std::filesystem::path& path, const std::string& what) {
  return fail(
      Status::malformed_volume,
      fmt::format("{}: {}: the VTK file is damaged; export the volume again", path.string(), what));
}

/// The array to read: the first scalars of the points, else of the cells; SCALARS before FIELDs.
const VtkArray* scalars_of(const std::vector<VtkArray>& arrays) {
  for (const bool of_cells : {false, true}) {
    for (const bool is_field : {false, true}) {
      for (const VtkArray& array : arrays) {
        if (array.of_cells == of_cells && array.is_field == is_field && array.components == 1 &&
            array.type) {
          return &array;
        }
      }
    }
  }
  return nullptr;
}

/// The error if the file may end before the scalars of points. In this case, those of cells must
/// not be read instead.
Result<void> check_point_data(const std::filesystem::path& path, const VtkFile& file,
                              const VtkArray& array) {
  const bool points_are_empty =
      file.has_point_data && std::none_of(file.arrays.begin(), file.arrays.end(),
                                          [](const VtkArray& a) { return !a.of_cells; });
  if (array.of_cells && (points_are_empty || (file.ends_early && &array != &file.arrays.back()))) {
    return fail(
        Status::truncated,
        fmt::format("{}: expected values of points, found the end of the file: it is incomplete; "
                    "copy or download it again",
                    path.string()));
  }
  return {};
}

/// The number of points or cells.
uint64_t count_of(const VtkFile& file, bool cells) {
  const auto [x, y, z] = file.dimensions;
  return cells ? array_bytes({x - 1, y - 1, z - 1}, 1, 1) : array_bytes({x, y, z}, 1, 1);
}

/// The array and component that the options select, or else the first scalars.
Result<GridNumber> choose(const std::filesystem::path& path, const VtkFile& file,
                          const ImportOptions& options, std::vector<std::string>& notes) {
  std::vector<GridArray> arrays;
  for (const VtkArray& array : file.arrays) {
    const uint64_t count = count_of(file, array.of_cells);
    const bool fits = array.type && count > 0 && array.values == count;
    arrays.push_back({array.name, array.of_cells, static_cast<size_t>(array.components), fits});
  }
  std::optional<size_t> scalars;
  if (const VtkArray* const found = scalars_of(file.arrays)) {
    scalars = static_cast<size_t>(found - file.arrays.data());
  }
  if (!scalars && std::none_of(arrays.begin(), arrays.end(),
                               [](const GridArray& each) { return each.is_readable; })) {
    for (const VtkArray& other : file.arrays) {
      if (other.components > 1) return not_scalar(path, other.components);
      return unknown_type(path, other.type_name);
    }
    return malformed(path, "expected POINT_DATA or CELL_DATA with SCALARS, found none");
  }
  return choose_array(path, arrays, scalars, options, notes);
}

/// Checks the data after the array. Errors: malformed_volume for values beyond the number that the
/// header declares, unless surplus is allowed.
Result<void> check_end(const std::filesystem::path& path, const VtkFile& file,
                       const VtkArray& array, Allowances allowed, std::vector<std::string>& notes) {
  if (file.ends_early && &array != &file.arrays.back()) {
    notes.push_back(fmt::format("the file is incomplete: it ends within the array '{}'",
                                file.arrays.back().name));
  }
  if (!file.has_surplus) return {};
  if (!allowed.has(Allowance::surplus)) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected a section or the end of the file after {} values, found "
                            "other data: the header's sizes or type do not fit the data; correct "
                            "them, or ignore the surplus with {}",
                            path.string(), array.values, flag_of(Allowance::surplus)));
  }
  notes.push_back("the data after the last section are ignored");
  return {};
}

/// The sizes and the geometry of the voxels.
struct Voxels {
  Vec3<int64_t> sizes;
  HeaderGeometry geometry;
};

/// A value per cell becomes a voxel at the cell's centre.
Voxels voxels_of(const VtkFile& file, const VtkArray& array, std::vector<std::string>& notes) {
  if (file.has_no_spacing) {
    notes.push_back(
        "the header has no voxel spacing: 1,1,1 is assumed; --spacing sets "
        "another");
  }
  Vec3<int64_t> sizes = file.dimensions;
  Vec3d origin = file.origin;
  if (array.of_cells) {
    sizes = {sizes.x - 1, sizes.y - 1, sizes.z - 1};
    origin = origin + file.spacing * 0.5;
    notes.push_back("the values belong to cells: each becomes a voxel at its cell's centre");
  }
  for (const double spacing : {file.spacing.x, file.spacing.y, file.spacing.z}) {
    if (spacing < 0) {
      notes.push_back(fmt::format("the spacing {} is negative: the axis is reversed", spacing));
    }
  }
  return {sizes, geometry_of_spacing(file.spacing, origin)};
}

}  // namespace

Result<OpenVolume> open_vtk_legacy(const std::filesystem::path& path,
                                   const ImportOptions& options) {
  auto file = read_vtk_sections(path, {"structured_points", "rectilinear_grid"});
  if (!file) return tl::unexpected(file.error());
  std::vector<std::string> notes;
  const auto chosen = choose(path, *file, options, notes);
  if (!chosen) return tl::unexpected(chosen.error());
  const VtkArray* const array = &file->arrays[chosen->array];
  if (auto checked = check_point_data(path, *file, *array); !checked) {
    return tl::unexpected(checked.error());
  }
  if (const auto step = choose_step(path, 1, options); !step) return tl::unexpected(step.error());
  if (file->dataset == "rectilinear_grid") {
    const auto uneven = place_vtk_axes(path, *file);
    if (!uneven) return tl::unexpected(uneven.error());
    if (*uneven != 0) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected evenly spaced coordinates along {}, found others: "
                              "isosplat build makes a scene of this grid; for a volume, resample "
                              "it to an image (in ParaView: Resample To Image), and save that",
                              path.string(), *uneven));
    }
  }
  const auto [sizes, geometry] = voxels_of(*file, *array, notes);
  const uint64_t needed = array_bytes(sizes, 1, 1);
  if (needed != array->values) {
    return malformed(
        path, fmt::format("expected {} values for {} × {} × {} {}, found a section of {}", needed,
                          sizes.x, sizes.y, sizes.z, array->of_cells ? "cells" : "points",
                          array->values));
  }
  if (auto checked = check_end(path, *file, *array, options.allowed, notes); !checked) {
    return tl::unexpected(checked.error());
  }
  ArrayVolume volume = make_array("VTK", path, sizes, geometry, options);
  volume.step_axis = 0;
  volume.steps = static_cast<uint64_t>(array->components);
  volume.step = chosen->component;
  volume.stored.type = *array->type;
  volume.stored.big_endian =
      file->is_binary || std::endian::native == std::endian::big;  // text: native voxels
  volume.ends_with_file = false;                                   // other arrays may follow
  volume.plain = file->is_binary;
  if (file->is_binary) volume.offset = array->offset;
  auto bytes =
      file->is_binary ? open_plain(path) : open_text_voxels(path, array->offset, *array->type);
  if (!bytes) return tl::unexpected(bytes.error());
  return open_array(std::move(volume), std::move(*bytes), std::move(notes));
}

}  // namespace isosplat::import
