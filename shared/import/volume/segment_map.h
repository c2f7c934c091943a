#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// A segment of a segmentation, as its file describes it.
struct SegmentDescription {
  int number = 0;       ///< its value in the SegmentMap
  std::string label;    ///< Segment Label; may be empty
  std::string meaning;  ///< of its codes, such as "Kidney, Right"; may be empty
  /// Recommended Display CIELab Value: L* from 0 to 100, a* and b* from −128 to 127, for the white
  /// point D50.
  std::optional<std::array<double, 3>> cie_lab;
};

/// Segments that do not overlap, as a volume of labels: each voxel has the number of its segment.
struct SegmentMap {
  OpenVolume volume;
  std::vector<SegmentDescription> segments;
  int64_t background = 0;        ///< the value of voxels outside all segments
  std::optional<int> only = {};  ///< the options choose this segment: other values are outside too
};

}  // namespace isosplat::import
