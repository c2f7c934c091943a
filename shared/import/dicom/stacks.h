#pragma once

#include <optional>

#include "shared/import/dicom/frames.h"
#include "shared/import/volume/import_options.h"

// Groups frames into stacks: frames of one series with the same size, orientation and pixel
// spacing.
namespace isosplat::import::dicom {

struct Stack {
  std::vector<uint32_t> frames;  ///< indices in Collection::frames
  /// For a segmentation: all frames of its file. The volume has a slice at each of their positions;
  /// where `frames` has none, the segment is empty. Empty if the stack is not a segmentation.
  std::vector<uint32_t> lattice = {};
  /// For a label map: voxels with this label become 1, all others 0.
  std::optional<int> label = std::nullopt;
};

/// Returns the frames of the stack that the options select; by default that of the series with the
/// most voxels. Adds a note about other series. Errors: malformed_volume if the series has several
/// stacks and the options select none, invalid_argument if they select one that does not exist.
Result<Stack> choose_stack(const Collection& collection, const std::filesystem::path& path,
                           const ImportOptions& options, std::vector<std::string>& notes);

/// All stacks of several slices, as choices of the option --series, with modality, size,
/// description and date. Errors: malformed_volume (too many stacks).
Result<std::vector<VolumeChoice>> list_stacks(const Collection& collection,
                                              const std::filesystem::path& path);

}  // namespace isosplat::import::dicom
