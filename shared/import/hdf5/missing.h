#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/import/hdf5/volumes.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// What the attributes of netCDF's conventions (CF) say about the numbers of an array. They are
/// compared with the numbers as they are stored, in their own type.
struct Hdf5Missing {
  std::vector<double> values;             ///< stand for no value: _FillValue, missing_value
  std::optional<double> least, greatest;  ///< numbers outside have no value: valid_range, …
};

/// Slope, intercept and type of the stored numbers (scale_factor, add_offset, _Unsigned) become
/// part of `stored`; the result says which of them have no value. `is_unsigned`: signed integers
/// stand for unsigned ones by another convention.
Hdf5Missing hdf5_values(Hdf5File& file, const Hdf5Volume& volume, bool is_unsigned,
                        StoredVoxels& stored);

/// Makes these voxels absent, with notes.
void remove_missing(const Hdf5Missing& missing, OpenVolume& volume);

}  // namespace isosplat::import
