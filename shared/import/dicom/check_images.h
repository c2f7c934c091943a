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

/// The frame of reference of an image for VolumeHeader: a hash of its UID, which could identify the
/// patient; empty: unknown.
std::string frame_of_reference(const Image& image);

/// That of frames. If the positions of the frames refer to different origins, it is unknown, and a
/// note is added.
std::string frame_of_reference(const Collection& collection, const std::vector<uint32_t>& frames,
                               std::vector<std::string>& notes);

}  // namespace isosplat::import::dicom
