#include "native/cli/histogram_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isosplat::cli {

std::string histogram_text(double low, double high, const std::vector<double>& counts, int rows) {
  if (counts.empty() || rows < 1) return {};
  const size_t row_count = std::min(counts.size(), static_cast<size_t>(rows));
  std::vector<double> sums(row_count);
  for (size_t i = 0; i < counts.size(); ++i) sums[i * row_count / counts.size()] += counts[i];
  const double longest = std::log2(1 + *std::max_element(sums.begin(), sums.end()));
  std::string text;
  constexpr int kWidth = 48;
  for (size_t row = 0; row < row_count; ++row) {
    const double begin =
        low + (high - low) * static_cast<double>(row) / static_cast<double>(row_count);
    const int eighths =
        longest > 0 ? static_cast<int>(std::lround(8 * kWidth * std::log2(1 + sums[row]) / longest))
                    : 0;
    std::string bar;
    for (int i = 0; i < eighths / 8; ++i) bar += "█";
    constexpr const char* kParts[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
    bar += kParts[eighths % 8];
    text += fmt::format("  {:>12.6g} {} {:.0f}\n", begin, bar, sums[row]);
  }
  return text;
}

}  // namespace isosplat::cli
