#include "native/headless/grey_range.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace isosplat {
namespace {

using Json = nlohmann::json;

/// The share of voxels that are darker than black, and of those that are brighter than white.
constexpr double kOutside = 0.005;

/// A member that is a finite number; otherwise NaN.
double number_at(const Json& json, const char* key) {
  const auto member = json.find(key);
  return member != json.end() && member->is_number() ? member->get<double>() : NAN;
}

/// Counts that are not negative; empty if the member has others.
std::vector<double> counts_at(const Json& json) {
  const auto member = json.find("counts");
  if (member == json.end() || !member->is_array()) return {};
  std::vector<double> counts;
  for (const Json& count : *member) {
    if (!count.is_number() || count.get<double>() < 0) return {};
    counts.push_back(count.get<double>());
  }
  return counts;
}

}  // namespace

GreyRange grey_range(std::string_view metadata, const GreyRange& all) {
  const Json json = Json::parse(metadata, nullptr, false);
  if (!json.is_object() || !json.contains("histogram") || !json["histogram"].is_object())
    return all;
  const Json& histogram = json["histogram"];
  const double low = number_at(histogram, "low"), high = number_at(histogram, "high");
  std::vector<double> counts = counts_at(histogram);
  if (!(low < high) || counts.empty()) return all;
  *std::max_element(counts.begin(), counts.end()) = 0;
  double total = 0;
  for (const double count : counts) total += count;
  size_t first = 0, last = counts.size() - 1;
  for (double darker = counts[first]; first < last && darker <= kOutside * total;) {
    darker += counts[++first];
  }
  for (double brighter = counts[last]; last > first && brighter <= kOutside * total;) {
    brighter += counts[--last];
  }
  const double width = (high - low) / static_cast<double>(counts.size());
  const GreyRange found{std::max(all.low, low + width * static_cast<double>(first)),
                        std::min(all.high, low + width * static_cast<double>(last + 1))};
  return total > 0 && found.low < found.high ? found : all;
}

}  // namespace isosplat
