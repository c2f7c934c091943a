#pragma once

#include <span>

#include "native/extract/extract.h"

namespace isosplat::python {

/// A box of voxels of a level: [first, first + count) along each axis.
struct VoxelBox {
  Index3 first, count;
};

/// Writes the values of the voxels in the box that are corners of stored cells. `values` has
/// count.x · count.y · count.z elements, x fastest; the other elements stay as they are. Calls
/// `check` between batches of chunks, on the calling thread. Of the options, `level` and `threads`
/// count. Scalar: float or double. Errors: not_found (no such level), those of extract_samples, and
/// the first error of `check`.
template <class Scalar>
Result<void> read_values(const StoreFile& store, const VoxelBox& box, const ExtractOptions& options,
                         const std::function<Result<void>()>& check, std::span<Scalar> values);

}  // namespace isosplat::python
