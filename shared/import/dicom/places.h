#pragma once

#include <filesystem>

#include "shared/import/dicom/frames.h"
#include "shared/import/dicom/groups.h"

// The positions of a file's frames (PS3.3, C.7.6.2 and C.7.6.16.2). Every assumption becomes a note
// of the image.
namespace isosplat::import::dicom {

/// Reads position, orientation and pixel spacing of each frame. A frame that does not state its
/// position stays unplaced. Errors: malformed_volume for values that are not numbers, or not
/// directions.
Result<void> read_places(const FrameGroups& groups, const std::filesystem::path& path, Image& image,
                         std::vector<Frame>& frames);

/// Positions the frames of a file that states one position for all of them: by offsets, slice
/// locations, or equal steps along the normal. Errors: malformed_volume for contradictions.
Result<void> place_together(const FrameGroups& groups, const std::filesystem::path& path,
                            Image& image, std::vector<Frame>& frames);

/// Replaces the only frame, which is a mosaic, by its slices. Refuses the image if the file does
/// not state their number. Errors: malformed_volume for contradictions.
Result<void> place_tiles(const FrameGroups& groups, const std::filesystem::path& path, Image& image,
                         std::vector<Frame>& frames);

}  // namespace isosplat::import::dicom
