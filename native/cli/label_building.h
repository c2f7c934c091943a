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
  LabelTable table;                    ///< empty: those of the volume's file, if it has any
  std::vector<FieldFile> fields = {};  ///< of the stores of all labels
};

/// Builds a scene with a layer for each label of a file, by value: a bundle or a folder
/// (SceneOutput). Equal values in several volumes of the file (label_inputs.h) are several layers.
/// Each store has the label's bounding box. Its surface is at kLabelFieldIsovalue. Prints notes and
/// progress on stderr. Errors: those of label_inputs, scan_labels, build_store_file, place_fields
/// and SceneOutput; malformed_volume if there are no labels; invalid_argument if the output is one
/// of the inputs.
Result<SceneReport> build_labels(const std::filesystem::path& volume,
                                 const std::filesystem::path& output,
                                 const LabelBuildOptions& options);

}  // namespace isosplat::cli
