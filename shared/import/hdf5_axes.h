#pragma once

#include <array>
#include <string>
#include <vector>

#include "shared/import/hdf5_volumes.h"
#include "shared/import/open_volume.h"
#include "shared/import/orientation.h"

namespace isosplat {

/// The three axes of a volume with several voxels, the slowest first, and where they lie.
struct Hdf5Axes {
  std::array<uint64_t, 3> sizes{};
  HeaderGeometry geometry;  ///< of the array: its fastest axis first; mm
  std::vector<std::string> notes;
};

/// The axes by the attributes of the volume: `axistags` (ilastik), or `axes` of its group (NeXus);
/// without names they are z, y and x. The spacing: options.spacing; `element_size_um` (Fiji,
/// ilastik); or the positions along the axes and their units (NeXus). Errors: unsupported_format if
/// an axis is one of channels or times, or if positions are not evenly spaced; those of reading the
/// positions.
Result<Hdf5Axes> hdf5_axes(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                           const ImportOptions& options);

}  // namespace isosplat
