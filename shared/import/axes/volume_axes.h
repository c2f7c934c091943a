#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/axes/array_axes.h"
#include "shared/import/geometry/orientation.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/voxels/chunked_reader.h"

namespace isosplat::import {

/// An array of a file, for messages.
struct NamedArray {
  std::filesystem::path file;
  std::string format;                 ///< "HDF5"
  std::string name;                   ///< of the array in the file
  bool has_other_attributes = false;  ///< that are not read
  std::string advice;  ///< a command that saves one volume of an array with too many axes
};

/// The part of an array that is a volume, and its geometry.
struct VolumeAxes {
  ArrayPart part;
  HeaderGeometry geometry;  ///< of the part: its fastest axis first; mm
  std::vector<std::string> notes;
};

/// The axes x, y and z of a described array. Axes without a letter become z, y and x in this order,
/// with a note. For axes of times or channels, the options choose an element. options.spacing
/// replaces the file's spacing. Errors: unsupported_format if more than three axes have several
/// elements; invalid_argument if a time step or a channel must be chosen, or does not exist.
Result<VolumeAxes> volume_axes(const NamedArray& array, ArrayDescription description,
                               const ImportOptions& options);

}  // namespace isosplat::import
