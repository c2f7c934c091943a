#pragma once

#include <cstdint>
#include <vector>

#include "shared/import/dicom/order.h"
#include "shared/import/dicom/order_input.h"

namespace isosplat::import::dicom {

/// Orders slices without positions: by their slice locations if these are all different, else by
/// their instance numbers. Errors: malformed_volume unless the options allow it, and if the numbers
/// are missing, duplicated or unevenly spaced; invalid_argument for a time step above 0.
Result<Arrangement> arrange_unplaced(const OrderInput& in, std::vector<uint32_t> frames);

}  // namespace isosplat::import::dicom
