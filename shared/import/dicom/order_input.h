#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/dicom/frames.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import::dicom {

/// The input for ordering the frames of a stack. Frames are indices in Collection::frames.
struct OrderInput {
  const Collection& collection;
  const std::filesystem::path& path;  ///< of the file or folder, for messages
  const ImportOptions& options;
  std::vector<std::string>& notes;  ///< to add to

  const Frame& frame_of(uint32_t frame) const { return collection.frames[frame]; }
  const Image& image_of(uint32_t frame) const { return collection.images[frame_of(frame).image]; }

  /// The file of a frame, and its number there, for messages.
  std::string name_of(uint32_t frame) const;

  /// The error malformed_volume.
  tl::unexpected<Error> malformed(const std::string& text) const;
};

}  // namespace isosplat::import::dicom
