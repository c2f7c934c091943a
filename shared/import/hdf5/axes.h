#pragma once

#include <string>
#include <vector>

#include "shared/import/geometry/orientation.h"
#include "shared/import/hdf5/array.h"
#include "shared/import/hdf5/description.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// The part of an array that is a volume, and its geometry.
struct Hdf5Axes {
  ArrayPart part;
  HeaderGeometry geometry;  ///< of the part: its fastest axis first; mm
  std::vector<std::string> notes;
};

/// The axes x, y and z of a described array. Axes without a letter become z, y and x in this order,
/// with a note. For axes of times or channels, the options choose an element. options.spacing
/// replaces the file's spacing. Errors: unsupported_format if more than three axes have several
/// elements; invalid_argument if a time step or a channel must be chosen, or does not exist.
Result<Hdf5Axes> hdf5_axes(const Hdf5File& file, const Hdf5Volume& volume,
                           Hdf5Description description, const ImportOptions& options);

}  // namespace isosplat::import
