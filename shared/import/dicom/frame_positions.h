#pragma once

#include <cstdint>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/import/dicom/order_input.h"

namespace isosplat::import::dicom {

struct PositionedFrame {
  uint32_t frame;
  double along;  ///< position along the normal
};

/// Tolerance of positions. Files round them to as little as 0.1 mm, so half of that, or a hundredth
/// of the slice distance, is accepted. A deviation of a tenth of the distance is always an error.
double position_tolerance(double spacing);

/// Frames with their positions along the normal, in order.
std::vector<PositionedFrame> in_order(const OrderInput& in, const std::vector<uint32_t>& frames,
                                      Vec3d normal);

/// The maximum distance in mm of frames that count as one position of a stack.
double same_position(const std::vector<PositionedFrame>& positioned);

/// One frame for each position.
std::vector<PositionedFrame> distinct(const std::vector<PositionedFrame>& positioned);

}  // namespace isosplat::import::dicom
