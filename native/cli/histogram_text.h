#pragma once

#include <string>
#include <vector>

namespace isosplat::cli {

/// A histogram as text of at most `rows` lines. Each line has the smallest value of its bin, a bar
/// and the count. Bars are logarithmic, since most voxels of a typical volume are air.
std::string histogram_text(double low, double high, const std::vector<double>& counts, int rows);

}  // namespace isosplat::cli
