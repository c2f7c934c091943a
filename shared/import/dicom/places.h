#pragma once

#include <filesystem>

#include "shared/import/dicom/frames.h"
#include "shared/import/dicom/groups.h"

// Where the frames of a file lie (PS3.3, C.7.6.2 and C.7.6.16.2). Everything that is assumed
// becomes a note of the image.
namespace isosplat::import::dicom {

/// Reads position, orientation and pixel spacing of each frame. A frame without a position of its
/// own stays unplaced. Errors: malformed_volume for values that are no numbers, or no directions.
Result<void> read_places(const FrameGroups& groups, const std::filesystem::path& path, Image& image,
                         std::vector<Frame>& frames);

/// Places the frames of a file that states one position for all of them: by offsets, slice
/// locations, or equal steps along the normal. Errors: malformed_volume for contradictions.
Result<void> place_together(const FrameGroups& groups, const std::filesystem::path& path,
                            Image& image, std::vector<Frame>& frames);

/// Replaces the only frame, which is a mosaic, by its slices. Refuses the image if the file lacks
/// their number. Errors: malformed_volume for contradictions.
Result<void> place_tiles(const FrameGroups& groups, const std::filesystem::path& path, Image& image,
                         std::vector<Frame>& frames);

}  // namespace isosplat::import::dicom
