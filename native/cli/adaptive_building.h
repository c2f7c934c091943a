#pragma once

#include <filesystem>

#include "native/cli/field_inputs.h"
#include "native/cli/grid_kind.h"
#include "native/cli/scene_building.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::cli {

struct AdaptiveBuildOptions {
  GridKind kind = GridKind::adaptive;  ///< of the volume: not regular
  SceneBuildOptions scene;
  import::ImportOptions import;
  std::vector<FieldFile> fields = {};  ///< of the stores of all levels
};

/// Builds a scene of an adaptive grid, or of an unstructured one, which is resampled to an adaptive
/// grid (shared/core/unstructured): a bundle or a folder (SceneOutput) with a layer and a store
/// for each refinement level (LevelSource). All stores have the same mapping to quantized values,
/// and the layers are parts of one volume (SceneLayer::part_of), so that they show one isosurface.
/// Half of the memory is for the grid and its fields. Prints notes and progress on stderr. Errors:
/// those of open_vtk_amr, open_vtk_mesh, resample, choose_drawn_cells, open_adaptive_fields,
/// build_store_file and SceneOutput; malformed_volume if no cell has a value; invalid_argument if
/// the output is one of the inputs.
Result<SceneReport> build_adaptive(const std::filesystem::path& volume,
                                   const std::filesystem::path& output,
                                   const AdaptiveBuildOptions& options);

}  // namespace isosplat::cli
