#include "shared/core/preprocess/isovalue_suggestions.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

constexpr uint32_t kBins = 256;

/// Isovalues show much the same if they are closer than this part of the range, or if the score
/// does not fall to this part of the lower one between them.
constexpr double kApart = 0.08;
constexpr double kValley = 0.97;

/// If there are fewer suggestions, steep surfaces are added.
constexpr size_t kFew = 3;

/// The agreement of gradients in noise that was smoothed a little, as by resampling.
constexpr double kAgreementOfNoise = 0.15;

/// A boundary is known to be one if there are this part of the voxels that a gradual change would
/// have with values a quarter of the cells' span below and above the isovalue.
constexpr double kExpectedVoxels = 0.1;

/// The weight of boundaries without voxels in between: labels have no others.
constexpr double kLeastWeight = 0.02;

/// The weight of noise: if there is nothing else, it is shown.
constexpr double kWeightOfNoise = 0.003;

/// This part of the voxels at each end of the range may be outliers, such as hot pixels. They must
/// not leave too few bins for all other voxels.
constexpr double kOutliers = 1e-5;

CellInterval range_without_outliers(const VolumeStatistics& statistics) {
  const CellInterval range = statistics.range();
  const QuantizedBins bins{range.min, 1, range.max - range.min + 1u};
  const std::vector<uint64_t> counts = statistics.histogram(bins);
  const double all = statistics.voxels_between(-1, range.max);
  const auto outliers = [&](auto begin, auto end) {
    double passed = 0;
    auto at = begin;
    while (at != end && (passed += static_cast<double>(*at)) <= kOutliers * all) ++at;
    return static_cast<uint32_t>(at - begin);
  };
  const CellInterval trimmed{
      static_cast<QuantizedValue>(range.min + outliers(counts.begin(), counts.end())),
      static_cast<QuantizedValue>(range.max - outliers(counts.rbegin(), counts.rend()))};
  // Perhaps the outliers are a small object in a volume that is empty otherwise.
  return trimmed.min < trimmed.max ? trimmed : range;
}

/// Small in noise, 1 if all gradients agree.
double weight_of_agreement(double agreement) {
  const double above = std::max(0.0, agreement - kAgreementOfNoise) / (1 - kAgreementOfNoise);
  return std::max(kWeightOfNoise, above * std::sqrt(above));
}

/// 1 if there are as many voxels with values beside an isovalue as in a gradual change.
double weight_of_voxels(double voxels, double in_gradual_change) {
  return std::clamp(voxels / (kExpectedVoxels * in_gradual_change), kLeastWeight, 1.0);
}

/// Means over neighbouring bins, with weights that fall evenly.
std::vector<double> smoothed(const std::vector<double>& values) {
  constexpr int32_t kReach = 4;
  const auto count = static_cast<int32_t>(values.size());
  std::vector<double> means(values.size());
  for (int32_t bin = 0; bin < count; ++bin) {
    double sum = 0, weights = 0;
    for (int32_t d = -kReach; d <= kReach; ++d) {
      if (bin + d < 0 || bin + d >= count) continue;
      const double weight = kReach + 1 - std::abs(d);
      sum += weight * values[static_cast<size_t>(bin + d)];
      weights += weight;
    }
    means[static_cast<size_t>(bin)] = sum / weights;
  }
  return means;
}

/// The highest bins, best first; of several equal ones, as masks have them, the middle one.
std::vector<size_t> peaks_of(const std::vector<double>& score) {
  constexpr double kEqual = 1e-9;  // sums of equal bins differ by rounding
  std::vector<size_t> peaks;
  for (size_t first = 0; first < score.size();) {
    size_t end = first + 1;
    while (end < score.size() && std::abs(score[end] - score[first]) <= kEqual * score[first]) {
      ++end;
    }
    const bool rises = first == 0 || score[first] > score[first - 1];
    const bool falls = end == score.size() || score[first] > score[end];
    if (rises && falls && score[first] > 0) peaks.push_back((first + end - 1) / 2);
    first = end;
  }
  std::stable_sort(peaks.begin(), peaks.end(),
                   [&](size_t a, size_t b) { return score[a] > score[b]; });
  return peaks;
}

/// Adds peaks of the score, best first, that show something else than those chosen before.
void choose(const std::vector<double>& score, size_t most, std::vector<size_t>& chosen) {
  for (const size_t peak : peaks_of(score)) {
    if (chosen.size() >= most) return;
    const bool is_known = std::any_of(chosen.begin(), chosen.end(), [&](size_t other) {
      const auto [from, to] = std::minmax(peak, other);
      const auto lowest = std::min_element(score.begin() + static_cast<ptrdiff_t>(from),
                                           score.begin() + static_cast<ptrdiff_t>(to));
      return static_cast<double>(to - from) < kApart * static_cast<double>(score.size()) ||
             *lowest > kValley * score[peak];
    });
    if (!is_known) chosen.push_back(peak);
  }
}

}  // namespace

std::vector<double> suggest_isovalues(const VolumeStatistics& statistics, size_t most) {
  std::vector<double> suggestions;
  const CellInterval range = range_without_outliers(statistics);
  if (range.min == range.max) return suggestions;
  const uint32_t bins = std::min<uint32_t>(kBins, range.max - range.min);
  const double width = static_cast<double>(range.max - range.min) / bins;
  std::vector<double> isovalues(bins);
  for (size_t bin = 0; bin < bins; ++bin) {
    isovalues[bin] = range.min + (static_cast<double>(bin) + 0.5) * width;
  }
  const std::vector<SurfaceStatistics> surfaces = statistics.surfaces(isovalues);
  std::vector<double> score(bins), steepness(bins);
  const double beside = 2 * width, lowest = range.min - 1.0 + beside;
  for (size_t bin = 0; bin < bins; ++bin) {
    const auto& [cells, span, agreement] = surfaces[bin];
    if (span <= 0) continue;
    const double below = std::max(lowest, isovalues[bin] - span / 4);
    const double above = std::min(range.max - beside, isovalues[bin] + span / 4);
    steepness[bin] = agreement > kAgreementOfNoise ? span : 0;
    score[bin] = span * std::sqrt(cells) * weight_of_agreement(agreement) *
                 weight_of_voxels(std::min(statistics.voxels_between(below - beside, below),
                                           statistics.voxels_between(above, above + beside)),
                                  cells * beside / span);
  }
  std::vector<size_t> chosen;
  choose(smoothed(score), most, chosen);
  // The small boundary of a strong material, such as bone, may lie on the slope of the large one of
  // another.
  choose(smoothed(steepness), std::min(most, kFew), chosen);
  for (const size_t bin : chosen) suggestions.push_back(isovalues[bin]);
  return suggestions;
}

}  // namespace isosplat
