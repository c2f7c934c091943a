#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "native/labels/label_table.h"
#include "shared/import/open_volume.h"

// The volumes of labels in a file. Labels of one volume do not overlap; those of several do.
namespace isosplat::cli {

struct LabelInput {
  std::function<Result<import::OpenVolume>()> open;  ///< call it once
  LabelTable table;                                  ///< names and colours
  std::optional<int64_t> background = 0;  ///< not a label; no value: all values are labels
  std::optional<int64_t> only = {};       ///< the only label that is wanted
};

/// The volumes of labels of a file or folder: the segments of a DICOM segmentation, the layers of a
/// segmentation of 3D Slicer, or one volume. `table`: replaces those of the file, unless it is
/// empty. Errors: those of open_segments and open_volume; invalid_argument for several time steps.
Result<std::vector<LabelInput>> label_inputs(const std::filesystem::path& file,
                                             const import::ImportOptions& options,
                                             const LabelTable& table);

}  // namespace isosplat::cli
