#pragma once

#include <optional>
#include <vector>

#include "shared/import/axes/array_attributes.h"
#include "shared/import/volume/opened_volume.h"
#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import {

/// Missing numbers of an array, by the attributes of netCDF's conventions (CF). They are compared
/// with the stored numbers, in the type of these.
struct MissingNumbers {
  std::vector<double> values;             ///< numbers for "no value": _FillValue, missing_value
  std::optional<double> least, greatest;  ///< numbers outside have no value: valid_range, …
};

/// Writes slope, intercept and type of the stored numbers (scale_factor, add_offset, _Unsigned) to
/// `stored`, and returns which numbers have no value. `is_unsigned`: by another convention, signed
/// integers represent unsigned ones.
MissingNumbers packed_values(const ArrayAttributes& attributes, bool is_unsigned,
                             StoredVoxels& stored);

/// Makes these voxels absent, with notes.
void remove_missing(const MissingNumbers& missing, OpenVolume& volume);

}  // namespace isosplat::import
