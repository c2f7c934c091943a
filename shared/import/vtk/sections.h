#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/grid.h"
#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import {

/// One array of a legacy VTK file.
struct VtkArray {
  std::string name;
  bool of_cells = false;
  bool is_field = false;          ///< from a FIELD section, not SCALARS or another attribute
  int components = 1;             ///< numbers per point or cell
  std::optional<VoxelType> type;  ///< nothing for unsupported types
  std::string type_name;
  uint64_t values = 0;  ///< number of points or cells with values
  uint64_t offset = 0;  ///< of the first value, in the file
  uint64_t end = 0;     ///< of the byte after the last value, and after a separator in text form
};

/// A legacy VTK file, without its values.
struct VtkFile {
  bool is_binary = false;
  std::string dataset;  ///< in lower case: structured_points, rectilinear_grid, …
  /// The arrays of positions and of cells: points; x_coordinates, y_coordinates, z_coordinates;
  /// cells, or offsets and connectivity (from version 5 on); cell_types.
  std::vector<VtkArray> geometry;
  Vec3<int64_t> dimensions;  ///< points along each axis; of unstructured grids 0
  Vec3d spacing{1, 1, 1};
  Vec3d origin{0, 0, 0};
  bool has_no_spacing = true;
  bool has_point_data = false;  ///< a POINT_DATA section exists
  bool ends_early = false;      ///< within the values of the last array
  bool has_surplus =
      false;  ///< the last section is followed by text that is not the name of a section
  std::vector<VtkArray> arrays;
};

/// Reads the sections of a file and skips their values. Binary values are skipped without reading;
/// text is read up to the last array. `datasets`: those that are read. Errors: io_error,
/// malformed_volume, truncated, unsupported_format for other data sets.
Result<VtkFile> read_vtk_sections(const std::filesystem::path& path,
                                  const std::vector<std::string_view>& datasets);

/// The name of the data set in the first lines of a file, in lower case; empty if it is none.
std::string vtk_dataset(std::string_view beginning);

}  // namespace isosplat::import
