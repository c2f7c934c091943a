#pragma once

#include "shared/import/dicom/frames.h"
#include "shared/import/volume/time_axis.h"

// Separates several frames at each position (times, echoes, gradients, …) by the attributes (keys)
// of the frames.
namespace isosplat::import::dicom {

/// Frames at the same position, for each position along the normal.
using Positions = std::vector<std::vector<uint32_t>>;

struct Steps {
  std::vector<std::vector<uint32_t>> frames;  ///< of each step, in the order of positions
  std::string distinguished_by;               ///< "trigger time", for messages
  TimeAxis times;                             ///< if that is a time since the same event
};

/// Divides frames into steps that have each position at most once. First it tries whole groups of
/// frames with equal values of one key, or of two keys. If every position has the same number of
/// frames, it then tries their rank by time or instance number. Returns no steps if no key
/// separates the frames.
Steps find_steps(const Collection& collection, const Positions& positions);

}  // namespace isosplat::import::dicom
