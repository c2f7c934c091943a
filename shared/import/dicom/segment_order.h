#pragma once

#include "shared/import/dicom/order.h"
#include "shared/import/dicom/order_input.h"
#include "shared/import/dicom/stacks.h"

namespace isosplat::import::dicom {

/// Orders the frames of a segment, whose stack has a lattice. Files omit frames without pixels of
/// the segment, so slices without a frame are background. Errors: those of arrange().
Result<Arrangement> arrange_segment(const OrderInput& in, const Stack& stack);

}  // namespace isosplat::import::dicom
