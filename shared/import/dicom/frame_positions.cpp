#include "shared/import/dicom/frame_positions.h"

#include <algorithm>

namespace isosplat::import::dicom {

double position_tolerance(double spacing) {
  return std::max(0.01 * spacing, std::min(0.1 * spacing, 0.06));
}

std::vector<PositionedFrame> in_order(const OrderInput& in, const std::vector<uint32_t>& frames,
                                      Vec3d normal) {
  std::vector<PositionedFrame> positioned;
  for (const uint32_t frame : frames) {
    positioned.push_back({frame, dot(in.frame_of(frame).position, normal)});
  }
  std::stable_sort(
      positioned.begin(), positioned.end(),
      [](const PositionedFrame& a, const PositionedFrame& b) { return a.along < b.along; });
  return positioned;
}

double same_position(const std::vector<PositionedFrame>& positioned) {
  // Distances may be much smaller than their mean if many slices are missing.
  const double extent = positioned.back().along - positioned.front().along;
  const double mean = extent / static_cast<double>(std::max<size_t>(positioned.size() - 1, 1));
  return std::min(0.05 * mean, 0.01);
}

std::vector<PositionedFrame> distinct(const std::vector<PositionedFrame>& positioned) {
  const double tolerance = same_position(positioned);
  std::vector<PositionedFrame> positions;
  for (const PositionedFrame& slice : positioned) {
    if (positions.empty() || slice.along - positions.back().along > tolerance)
      positions.push_back(slice);
  }
  return positions;
}

}  // namespace isosplat::import::dicom
