#pragma once

#include <string_view>

namespace isosplat {

struct GreyRange {
  double low = 0, high = 1;
};

/// The values that slices show as black and white, if neither the visitor nor the scene chooses:
/// the values outside of which 0.5 % of the voxels lie at either end, so that a few bright voxels
/// do not darken the others. Voxels in the fullest bin of the histogram, which are mostly
/// background, do not count. `metadata`: of the store (FORMAT.md), with its histogram. Without a
/// usable histogram: `all`, the range of the store's values. The page does the same:
/// web/viewer/grey_range.ts.
GreyRange grey_range(std::string_view metadata, const GreyRange& all);

}  // namespace isosplat
