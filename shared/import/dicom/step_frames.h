#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/import/dicom/frame_positions.h"
#include "shared/import/dicom/order_input.h"
#include "shared/import/volume/time_axis.h"

// Selects one of the volumes (times, echoes, …) that a stack has at the same positions.
namespace isosplat::import::dicom {

/// The frames of the time step that the options select, one for each position. `may_lack`:
/// positions may lack a frame of the step. Errors: invalid_argument without a valid time step;
/// malformed_volume for frames at the same position that no attribute distinguishes, or for missing
/// slices; no_cells for frames at a single position.
Result<std::vector<uint32_t>> frames_of_step(const OrderInput& in,
                                             const std::vector<PositionedFrame>& positioned,
                                             bool may_lack);

/// Selects one of several volumes by the options. Errors: invalid_argument.
Result<size_t> chosen_step(const OrderInput& in, size_t count, const std::string& distinguished_by,
                           const TimeAxis& times = {});

}  // namespace isosplat::import::dicom
