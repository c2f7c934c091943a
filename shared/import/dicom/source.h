#pragma once

#include <memory>
#include <span>

#include "shared/core/grid/volume_source.h"
#include "shared/import/dicom/order.h"
#include "shared/import/dicom/values.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import::dicom {

/// A source that reads the slices of `planes` from their files and keeps no voxels in memory. It
/// copies the images that `planes` use. `reverse_rows`: each slice's rows are read in reverse
/// order.
std::unique_ptr<VolumeSource> make_dicom_source(VolumeHeader header, const Collection& collection,
                                                std::span<const Plane> planes, const Values& values,
                                                bool reverse_rows, const ImportOptions& options);

}  // namespace isosplat::import::dicom
