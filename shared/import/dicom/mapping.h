#pragma once

#include <filesystem>

#include "shared/import/dicom/frames.h"
#include "shared/import/dicom/groups.h"

// The mapping from stored pixels to values (PS3.3, C.11.1 and C.7.6.16.2.11).
namespace isosplat::import::dicom {

/// Reads the slope and intercept of frame `i`: Rescale Slope and Intercept; else Dose Grid Scaling;
/// else a Real World Value Mapping. Adds notes to the image about assumptions and unused mappings,
/// and refuses the image if its values are in tables. `quantity` becomes the label of the mapping,
/// if there is one. Errors: malformed_volume.
Result<void> read_mapping(const FrameGroups& groups, size_t i, const std::filesystem::path& path,
                          Image& image, Frame& frame, std::string& quantity);

}  // namespace isosplat::import::dicom
