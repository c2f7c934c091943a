#include "shared/render/pick/thin_structure.h"

#include <algorithm>
#include <cmath>

#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

struct CornerValues {
  double mean = 0, low = HUGE_VAL, high = -HUGE_VAL;
  std::array<double, 3> gradient{};  // at the centre

  explicit CornerValues(const UnpackedSample& cell) {
    for (size_t i = 0; i < 8; ++i) {
      const double value = double(cell.corners[i]);
      mean += value / 8;
      low = std::min(low, value);
      high = std::max(high, value);
      for (size_t axis = 0; axis < 3; ++axis)
        gradient[axis] += (i >> axis & 1 ? value : -value) / 4;
    }
  }
};

/// Removes, from the spanned axes, the one on which the slope is the largest.
void leave_steepest(std::array<bool, 3>& spanned, const std::array<double, 3>& gradient) {
  size_t steepest = 3;
  for (size_t axis = 0; axis < 3; ++axis) {
    if (spanned[axis] &&
        (steepest == 3 || std::abs(gradient[axis]) > std::abs(gradient[steepest]) + 1e-4)) {
      steepest = axis;
    }
  }
  if (steepest < 3) spanned[steepest] = false;
}

}  // namespace

float thickened_isovalue(const UnpackedSample& cell, float quantized_isovalue) {
  const CornerValues values(cell);
  const double isovalue = double(quantized_isovalue);
  const double side = values.mean < isovalue ? 1 : -1;
  const double from = side > 0 ? cell.interval.min : cell.interval.max;
  const double span = std::max(cell.interval.max - cell.interval.min, 1);
  const double peak = ((side > 0 ? values.high : -values.low) - side * from) / span;
  const double level = side * (isovalue - from) / span;
  if (peak < level) return quantized_isovalue;
  const double lowered =
      peak * (1 - THIN_LOWER * std::sqrt(std::max(peak * (1 - peak) * (1 - level), 0.0)));
  return static_cast<float>(from + side * std::min(level, lowered) * span);
}

bool is_within_corners(const UnpackedSample& cell, float quantized_isovalue) {
  const auto [low, high] = std::minmax_element(cell.corners.begin(), cell.corners.end());
  return *low <= quantized_isovalue && quantized_isovalue <= *high;
}

ThinBox thin_box(const UnpackedSample& cell, NeighbourBits neighbours, float quantized_isovalue,
                 double voxel) {
  const CornerValues values(cell);
  const double isovalue = double(quantized_isovalue);
  const bool up = values.mean < isovalue;
  const double from = up ? cell.interval.min : cell.interval.max;
  const double span = (up ? cell.interval.max : cell.interval.min) - from;
  const double level = std::clamp((isovalue - from) / span, 0.01, 1.0);
  const double share = std::clamp(
      THIN_SHARE * (values.mean - from) / span * -double{std::log(static_cast<float>(level))},
      THIN_LEAST, 1.0);
  ThinBox box;
  for (size_t axis = 0; axis < 3; ++axis) box.spanned[axis] = (neighbours >> 2 * axis & 3) == 3;
  const auto count = [&] { return std::count(box.spanned.begin(), box.spanned.end(), true); };
  if (count() == 3) leave_steepest(box.spanned, values.gradient);
  if (count() == 2 && share < THIN_SHEET_VOXELS * voxel)
    leave_steepest(box.spanned, values.gradient);
  const double side = count() == 2 ? share : count() == 1 ? std::sqrt(share) : std::cbrt(share);
  const double distance = values.mean - from;
  const auto along = [&](size_t axis, double& low, double& high) {
    const double extent = box.spanned[axis] ? 1 : side;
    const double middle =
        0.5 + (std::abs(distance) > 0.5 ? 0.25 * values.gradient[axis] / distance : 0);
    const uint32_t pair = neighbours >> 2 * axis & 3;
    low = pair == 1 ? 0 : pair == 2 ? 1 - extent : std::clamp(middle - extent / 2, 0.0, 1 - extent);
    high = low + extent;
  };
  along(0, box.low.x, box.high.x);
  along(1, box.low.y, box.high.y);
  along(2, box.low.z, box.high.z);
  return box;
}

}  // namespace isosplat::render
