#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/geometry/orientation.h"
#include "shared/import/volume/time_axis.h"
#include "shared/import/volume/volume_choices.h"
#include "shared/import/zarr/metadata.h"

namespace isosplat::import::zarr {

/// An axis of an array, by its metadata.
struct Axis {
  std::string name, unit;  ///< empty: not stated
};

/// One scale of an image of OME-Zarr (0.1 to 0.5, ngff.openmicroscopy.org), or an array by itself.
struct Scale {
  std::string path;  ///< of the array, below the image; empty: the array itself
  std::vector<double> scale, translation;  ///< of each axis, in its unit
};

/// What a path in a hierarchy contains.
struct Image {
  std::filesystem::path folder;              ///< the base of the paths of the scales
  std::vector<Scale> scales;                 ///< in the order of the metadata: the finest first
  std::optional<size_t> chosen;              ///< the scale that the path names
  std::vector<Axis> axes;                    ///< empty: not stated
  std::vector<ChannelDescription> channels;  ///< of omero; may be empty
  bool is_ome = false;
};

/// Reads the metadata of the image or the array at a path: a group with multiscales (the first),
/// one of its arrays, the first image of a hierarchy of bioformats2raw, or any array. Errors: those
/// of read_node; unsupported_format for other groups.
Result<Image> read_image(const std::filesystem::path& folder);

/// The indices of x, y and z among the axes of an array, by their names; without names, the last
/// three, reversed. Errors: no_cells.
Result<std::array<size_t, 3>> spatial_axes(const std::vector<Axis>& axes,
                                           const std::filesystem::path& folder);

/// The positions of voxels, in millimetres. Lengths of an unknown unit, or without one, are taken
/// as millimetres, with a note.
HeaderGeometry geometry_of(const Scale& scale, const std::vector<Axis>& axes,
                           const std::array<size_t, 3>& spatial, std::vector<std::string>& notes);

/// The name of an image: its folder with the ending .zarr, and the path below it.
std::string name_of(const std::filesystem::path& folder);

}  // namespace isosplat::import::zarr
