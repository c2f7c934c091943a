#pragma once

#include <vector>

#include "shared/import/dicom/frame_positions.h"
#include "shared/import/dicom/order_input.h"
#include "shared/import/geometry/orientation.h"

// Position, axes and spacing of a stack, from its frames in order.
namespace isosplat::import::dicom {

/// Sets origin, axes and pixel spacing to those of the first frame. If the spacing is unknown, it
/// becomes 1 mm, with a note.
void set_plane(const OrderInput& in, const Frame& frame, HeaderGeometry& geometry);

/// Checks that all slices are shifted in their plane by the same vector relative to the previous
/// slice (gantry tilt). Errors: malformed_volume.
Result<void> check_shift(const OrderInput& in, const std::vector<PositionedFrame>& positioned,
                         const HeaderGeometry& geometry);

/// Sets the third axis, which points from the first slice to the last, and the slice distance.
/// `extent`: extent of the positions along the normal; `count`: number of steps between them. Adds
/// notes about a gantry tilt, and about a different distance in the header.
void set_third_axis(const OrderInput& in, const std::vector<PositionedFrame>& positioned,
                    double extent, double count, HeaderGeometry& geometry);

}  // namespace isosplat::import::dicom
