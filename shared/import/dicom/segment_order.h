#pragma once

#include "shared/import/dicom/order.h"
#include "shared/import/dicom/order_input.h"
#include "shared/import/dicom/stacks.h"

namespace isosplat::import::dicom {

/// The slices of a segmentation. They are equally spaced, and each frame is at one of them. Files
/// omit frames without pixels of a segment.
struct SegmentLattice {
  HeaderGeometry geometry;
  uint32_t first = 0;            ///< the frame at the first position
  Vec3d normal{0, 0, 1};         ///< of the slices
  double begin = 0, extent = 1;  ///< of the positions along the normal, mm
  double steps = 1;              ///< number of slices − 1

  size_t slice_of(const Frame& frame) const;
};

/// The lattice of a file's frames. Each frame must have a position. Errors: malformed_volume for
/// uneven distances or shifts; no_cells for a single position.
Result<SegmentLattice> segment_lattice(const OrderInput& in, const std::vector<uint32_t>& frames);

/// Orders the frames of a segment. `stack` must have a lattice. Slices without a frame are
/// background. Errors: those of arrange().
Result<Arrangement> arrange_segment(const OrderInput& in, const Stack& stack);

}  // namespace isosplat::import::dicom
