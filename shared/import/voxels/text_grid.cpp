#include "shared/import/voxels/text_grid.h"

#include <bit>

#include "shared/import/geometry/conventions.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/text_voxels.h"

namespace isosplat::import {

Result<OpenVolume> open_text_grid(const std::filesystem::path& path, const TextGrid& grid,
                                  const ImportOptions& options, std::vector<std::string> notes) {
  if (const auto step = choose_step(path, 1, options); !step) return tl::unexpected(step.error());
  HeaderGeometry geometry = geometry_of_steps(grid.steps, grid.origin);
  scale_lengths(grid.unit, geometry);
  ArrayVolume array = make_array(grid.format, path, grid.voxels, geometry, options);
  array.stored.type = VoxelType::f64;
  array.stored.big_endian = std::endian::native == std::endian::big;
  array.stored.slope = grid.slope;
  array.step_axis = 0;
  array.steps = grid.components;
  array.step = grid.component;
  array.plain = false;
  array.ends_with_file = grid.ends_with_file;
  auto values = open_text_voxels(path, grid.begin, VoxelType::f64);
  if (!values) return tl::unexpected(values.error());
  return open_array(std::move(array), std::move(*values), std::move(notes));
}

}  // namespace isosplat::import
