#pragma once

#include "shared/import/dicom/stacks.h"
#include "shared/import/volume/import_options.h"

// Segmentations (PS3.3, A.51 and C.8.20).
namespace isosplat::import::dicom {

/// The frames of the segment that the options choose, if the stack is a segmentation; other stacks
/// are returned unchanged. Adds a note about the segment. Errors: invalid_argument if there are
/// several segments and the options choose none, or choose one that does not exist or has no
/// frames.
Result<Stack> choose_segment(const Collection& collection, Stack stack,
                             const std::filesystem::path& path, const ImportOptions& options,
                             std::vector<std::string>& notes);

}  // namespace isosplat::import::dicom
