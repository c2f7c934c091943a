#pragma once

#include <memory>
#include <span>

#include "shared/import/dicom_order.h"
#include "shared/import/dicom_values.h"
#include "shared/import/open_volume.h"

namespace isosplat::dicom {

/// A source that reads the slices of `planes` from their files and keeps no voxels in memory. It
/// copies the images that `planes` use. `reverse_rows`: each slice's rows are read in reverse
/// order.
std::unique_ptr<VolumeSource> make_dicom_source(VolumeHeader header, const Collection& collection,
                                                std::span<const Plane> planes, const Values& values,
                                                bool reverse_rows, const ImportOptions& options);

}  // namespace isosplat::dicom
