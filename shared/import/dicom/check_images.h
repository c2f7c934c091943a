#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/import/dicom/frames.h"
#include "shared/import/volume/import_options.h"

// Checks of the files whose frames a volume consists of. Frames are indices in Collection::frames.
namespace isosplat::import::dicom {

/// Checks the files of frames that were chosen. Adds notes about their assumptions, and about
/// faults that the options allow. Errors: those of Image::refusal; truncated, malformed_volume
/// (surplus, or a missing part of a concatenation).
Result<void> check_images(const Collection& collection, const std::vector<uint32_t>& frames,
                          const std::filesystem::path& path, const ImportOptions& options,
                          std::vector<std::string>& notes);

/// Adds a note if the positions of the frames refer to different origins.
void note_frames_of_reference(const Collection& collection, const std::vector<uint32_t>& frames,
                              std::vector<std::string>& notes);

}  // namespace isosplat::import::dicom
