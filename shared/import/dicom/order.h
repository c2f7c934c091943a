#pragma once

#include "shared/import/dicom/stacks.h"
#include "shared/import/geometry/orientation.h"
#include "shared/import/volume/import_options.h"

// Orders a stack's frames by their positions. If the stack has several volumes (times, echoes, …),
// selects one of them.
namespace isosplat::import::dicom {

/// A slice of the volume: (1 − weight) · first + weight · second; or the background of the
/// segmentation that `first` belongs to.
struct Plane {
  uint32_t first = 0, second = 0;  ///< indices in Collection::frames
  double weight = 0;               ///< 0 unless the slice is interpolated; < 1
  bool is_background = false;      ///< the segmentation has no frame here, so no segment
};

struct Arrangement {
  std::vector<Plane> planes;  ///< in order along the slice normal
  HeaderGeometry geometry;    ///< LPS, mm; if slices are sheared, the third axis is not the normal
};

/// Orders a stack by its positions. Errors: malformed_volume for slices that are missing, unevenly
/// spaced, irregularly shifted, or at the same position without a distinguishing attribute;
/// invalid_argument for a stack of several volumes without a valid time step; no_cells for a single
/// slice.
Result<Arrangement> arrange(const Collection& collection, const Stack& stack,
                            const std::filesystem::path& path, const ImportOptions& options,
                            std::vector<std::string>& notes);

}  // namespace isosplat::import::dicom
