#pragma once

#include "native/extract/extract.h"

namespace isosplat::python {

struct SurfaceMeasures {
  double area = 0;          ///< world units²
  double volume_above = 0;  ///< world units³: of the region above the isovalue
};

/// Area and enclosed volume of an isosurface at level 0 (shared/core/mesh/surface_extent.h). They
/// do not depend on the number of threads. Calls `check` between batches of chunks, on the calling
/// thread. Errors: those of extract_samples, and the first error of `check`.
Result<SurfaceMeasures> measure_surface(const StoreFile& store, double isovalue,
                                        const ExtractOptions& options,
                                        const std::function<Result<void>()>& check);

}  // namespace isosplat::python
