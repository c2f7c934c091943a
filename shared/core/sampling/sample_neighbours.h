#pragma once

#include <span>

#include "shared/core/sampling/packed_sample.h"

namespace isosplat {

/// Bits of neighbours_of(): the cells beyond the faces x = 0, x = 1, y = 0, y = 1, z = 0, z = 1.
using NeighbourBits = uint32_t;

/// Sets the neighbour bits of a coarse chunk's samples (PackedSample): across which faces a
/// structure that is thinner than the cell may continue. It continues into a neighbour that is in
/// the chunk and whose interval overlaps at least half of the cell's. Cells beyond the block are
/// not known: the result for the opposite face is used for them. Samples may have any order; their
/// cells differ.
void mark_neighbours(std::span<PackedSample> samples);

/// The neighbour bits of a sample; 0 if they have not been set.
NeighbourBits neighbours_of(const PackedSample& sample);

}  // namespace isosplat
