#pragma once

#include <vector>

#include "native/extract/extract.h"

namespace isosplat::python {

/// The low corners of all active cells of a level, in cells of the level; block after block. Calls
/// `check` between batches of chunks, on the calling thread. Errors: those of extract_samples, and
/// the first error of `check`.
Result<std::vector<Index3>> active_cells(const StoreFile& store, double isovalue,
                                         const ExtractOptions& options,
                                         const std::function<Result<void>()>& check);

}  // namespace isosplat::python
