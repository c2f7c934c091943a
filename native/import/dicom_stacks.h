#pragma once

#include "native/import/dicom_frames.h"
#include "native/import/open_volume.h"

// The stacks that frames form: frames of one series that have their size, orientation and pixel
// spacing in common.
namespace isosplat::dicom {

struct Stack {
  std::vector<uint32_t> frames;  ///< in Collection::frames
};

/// The frames of the stack that the options name, or of the series with the most voxels. `notes`
/// gets what else there is. Errors: malformed_volume where the series has several stacks and the
/// options do not say which, invalid_argument where they name one that is not there.
Result<Stack> choose_stack(const Collection& collection, const std::filesystem::path& path,
                           const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace isosplat::dicom
