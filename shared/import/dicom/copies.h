#pragma once

#include <cstdint>
#include <vector>

#include "shared/import/dicom/order_input.h"

namespace isosplat::import::dicom {

/// The frames without those of duplicate files, in the same order. Adds a note about duplicates.
/// Errors: malformed_volume if different slices have the same SOP Instance UID.
Result<std::vector<uint32_t>> without_copies(const OrderInput& in,
                                             const std::vector<uint32_t>& frames);

}  // namespace isosplat::import::dicom
