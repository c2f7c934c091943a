#pragma once

#include "native/import/dicom_frames.h"

// Several frames at each place: moments, echoes, gradients, … What tells them apart is looked for
// among the keys of the frames.
namespace isosplat::dicom {

/// Frames at the same place, for each place along the normal.
using Places = std::vector<std::vector<uint32_t>>;

struct Steps {
  std::vector<std::vector<uint32_t>> frames;  ///< of each step, in the order of the places
  std::string distinguished_by;               ///< "trigger time", for messages
};

/// Divides frames into steps that hold each place at most once. First, whole groups of frames with
/// the same values of one key, or of two; then, where every place has as many frames, by their rank
/// at each place in time or instance number. No steps: nothing tells them apart.
Steps find_steps(const Collection& collection, const Places& places);

}  // namespace isosplat::dicom
