#pragma once

#include <string>
#include <vector>

namespace isosplat::cli {

/// A histogram as lines of text, one per row of up to `rows`: the values that the row begins with,
/// and a bar. Bars are logarithmic, as a volume has far more air than anything else.
std::string histogram_text(double low, double high, const std::vector<double>& counts, int rows);

}  // namespace isosplat::cli
