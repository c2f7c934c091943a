#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/import/geometry/orientation.h"
#include "shared/import/nrrd/header.h"
#include "shared/import/volume/volume_choices.h"

namespace isosplat::import {

/// The axes of an NRRD file: three spatial axes, and at most one other axis with more than one
/// sample, of times or of channels.
struct NrrdAxes {
  Vec3<int64_t> voxels;     ///< along the spatial axes, in file order
  HeaderGeometry geometry;  ///< in LPS and millimetres
  size_t step_axis = 3;     ///< position of the other axis among the four; 3 if there is none
  int64_t steps = 1;        ///< number of samples of the other axis
  TimeAxis times;           ///< of these
  /// The other axis has the components of a voxel: colours, vectors, matrices, or the layers of a
  /// segmentation, whose segments may overlap.
  bool are_channels = false;
  std::vector<ChannelDescription> channels;  ///< of colours
  std::vector<std::string> notes;
};

/// Reads axes and geometry. Axes with one sample that are not spatial are ignored.
///
/// An axis is spatial if it has a space direction. If no axis has one, an axis is spatial if its
/// kind is "domain" or "space". If the header has no kinds either, the first three axes are
/// spatial.
///
/// Errors: malformed_volume; no_cells for 2D images; unsupported_format for more than one other
/// axis.
Result<NrrdAxes> read_nrrd_axes(const std::filesystem::path& path, const NrrdHeader& header);

}  // namespace isosplat::import
