#pragma once

#include "native/import/dicom_stacks.h"
#include "native/import/orientation.h"

// Which frame lies where: a stack's frames in the order of their positions, one volume of them
// where they are several (times, echoes, …).
namespace isosplat::dicom {

/// A slice of the volume: (1 − weight) · first + weight · second.
struct Plane {
  uint32_t first = 0, second = 0;  ///< in Collection::frames
  double weight = 0;               ///< 0 except for slices that are interpolated, < 1
};

struct Arrangement {
  std::vector<Plane> planes;  ///< along the normal of the slices
  HeaderGeometry geometry;  ///< LPS, mm; its third axis is not the normal where slices are shifted
};

/// Orders a stack by its positions. Errors: malformed_volume for slices that are missing, unevenly
/// spaced, shifted against each other, or at the same place without a reason; invalid_argument for
/// a stack of several volumes without a valid time step; no_cells for a single slice.
Result<Arrangement> arrange(const Collection& collection, const Stack& stack,
                            const std::filesystem::path& path, const ImportOptions& options,
                            std::vector<std::string>& notes);

}  // namespace isosplat::dicom
