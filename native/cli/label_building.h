#pragma once

#include <filesystem>
#include <string>

#include "native/cli/scene_building.h"
#include "native/labels/label_source.h"
#include "native/labels/label_table.h"

namespace isosplat::cli {

struct LabelBuildOptions {
  SceneBuildOptions scene;
  import::ImportOptions import;
  LabelSurface surface = LabelSurface::smooth;
  LabelTable table;  ///< empty: that of the volume's file, if it has one
};

/// Builds a scene with a layer for each label of a volume, by value: a bundle or a folder
/// (SceneOutput). Each store has the label's bounding box. Its surface is at kLabelFieldIsovalue.
/// Prints notes and progress on stderr. Errors: those of open_volume, scan_labels, build_store_file
/// and SceneOutput; invalid_argument if the output is one of the inputs.
Result<SceneReport> build_labels(const std::filesystem::path& volume,
                                 const std::filesystem::path& output,
                                 const LabelBuildOptions& options);

}  // namespace isosplat::cli
