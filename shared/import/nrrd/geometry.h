#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/import/geometry/conventions.h"
#include "shared/import/geometry/orientation.h"
#include "shared/import/nrrd/header.h"

namespace isosplat::import {

/// One axis, from the header's per-axis fields. Numbers that the header does not have are NaN.
struct NrrdAxis {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  int64_t size = 0;
  std::string kind;
  double spacing = kNone, min = kNone, max = kNone;
  std::string center, unit;
  std::optional<std::vector<double>> direction;
  bool is_none = false;  ///< its entry in "space directions" is "none"
};

/// The dimension of a space and its frame.
struct NrrdSpace {
  size_t dimension = 0;  ///< 0: the header has no space
  Frame frame = Frame::lps;
};

/// Reads "space" or "space dimension". Errors: malformed_volume for an unknown space;
/// unsupported_format for a space of other than three dimensions, or four with time.
Result<NrrdSpace> read_nrrd_space(const std::filesystem::path& path, const NrrdHeader& header);

/// The geometry of a volume in LPS and millimetres. `spatial`: the indices of the spatial axes in
/// `axes`. Either all or none of them have a direction. Errors: malformed_volume.
Result<HeaderGeometry> nrrd_geometry(const std::filesystem::path& path, const NrrdHeader& header,
                                     const std::vector<NrrdAxis>& axes,
                                     std::span<const size_t, 3> spatial, const NrrdSpace& space,
                                     std::vector<std::string>& notes);

}  // namespace isosplat::import
