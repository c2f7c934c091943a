#include "shared/core/preprocess/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace isosplat {
namespace {

constexpr size_t kQuantizedValues = 65536;

/// Only every kSpanStride-th cell counts for mean spans, to save time.
constexpr size_t kSpanStride = 5;

template <class T>
void count_values(const T* quantized_values, size_t count, std::vector<uint64_t>& into) {
  // Four tables in turn: increments of the same entry would have to wait for each other, and
  // neighbours are often equal.
  constexpr size_t kTables = sizeof(T) == 1 ? 4 : 1;
  constexpr size_t kSize = sizeof(T) == 1 ? 256 : 1;
  if constexpr (kTables == 1) {
    for (size_t i = 0; i < count; ++i) ++into[quantized_values[i]];
  } else {
    std::array<std::array<uint32_t, kSize>, kTables> tables{};
    size_t i = 0;
    for (; i + kTables <= count; i += kTables) {
      for (size_t t = 0; t < kTables; ++t) ++tables[t][quantized_values[i + t]];
    }
    for (; i < count; ++i) ++tables[0][quantized_values[i]];
    for (size_t c = 0; c < kSize; ++c) {
      for (const auto& table : tables) into[c] += table[c];
    }
  }
}

}  // namespace

VolumeStatistics::VolumeStatistics()
    : voxels_(kQuantizedValues),
      minima_(kQuantizedValues),
      maxima_(kQuantizedValues),
      spans_from_(kQuantizedValues),
      spans_to_(kQuantizedValues) {}

void VolumeStatistics::add_values(const void* quantized_values, size_t count, uint8_t bits,
                                  bool has_missing) {
  if (bits == 8) {
    // The tables of one call hold 32-bit counts.
    constexpr size_t kAtOnce = size_t{1} << 30;
    const auto* at = static_cast<const uint8_t*>(quantized_values);
    for (; count > 0; at += std::min(count, kAtOnce), count -= std::min(count, kAtOnce)) {
      count_values(at, std::min(count, kAtOnce), voxels_);
    }
  } else {
    count_values(static_cast<const uint16_t*>(quantized_values), count, voxels_);
  }
  if (has_missing) {
    missing_ += voxels_[kMissingVoxel];
    voxels_[kMissingVoxel] = 0;
  }
}

void VolumeStatistics::add_block(const BandPlanner& planner,
                                 std::span<const CellInterval> intervals) {
  if (planner.cells() == 0) return;
  const CellInterval range = planner.interval();
  const auto minima = planner.minima(), maxima = planner.maxima();
  for (size_t i = 0; i < minima.size(); ++i) {
    minima_[range.min + i] += minima[i];
    maxima_[range.min + i] += maxima[i];
  }
  for (size_t i = 0; i < intervals.size(); i += kSpanStride) {
    // No branch for cells that are never active, because it could not be predicted: their span is
    // 0.
    const auto [min, max] = intervals[i];
    const auto span = static_cast<uint64_t>(std::max(max - min, 0));
    spans_from_[min] += span;
    spans_to_[max] += span;
  }
}

void VolumeStatistics::add(const VolumeStatistics& other) {
  const auto sum = [](std::vector<uint64_t>& to, const std::vector<uint64_t>& from) {
    for (size_t i = 0; i < kQuantizedValues; ++i) to[i] += from[i];
  };
  sum(voxels_, other.voxels_);
  sum(minima_, other.minima_);
  sum(maxima_, other.maxima_);
  sum(spans_from_, other.spans_from_);
  sum(spans_to_, other.spans_to_);
  missing_ += other.missing_;
}

std::vector<std::byte> VolumeStatistics::bytes() const {
  std::vector<std::byte> all;
  const auto append = [&](std::span<const uint64_t> counts) {
    const auto part = std::as_bytes(counts);
    all.insert(all.end(), part.begin(), part.end());
  };
  for (const auto* counts : {&voxels_, &minima_, &maxima_, &spans_from_, &spans_to_}) {
    append(*counts);
  }
  append(std::span(&missing_, 1));
  return all;
}

Result<void> VolumeStatistics::add(std::span<const std::byte> bytes) {
  if (bytes.size() != (5 * kQuantizedValues + 1) * sizeof(uint64_t)) {
    return fail(Status::invalid_argument,
                "the statistics of an encoder are of another version, or incomplete: load the page "
                "again");
  }
  const std::byte* at = bytes.data();
  const auto next = [&at] {
    uint64_t count = 0;
    std::memcpy(&count, at, sizeof count);
    at += sizeof count;
    return count;
  };
  for (auto* counts : {&voxels_, &minima_, &maxima_, &spans_from_, &spans_to_}) {
    for (uint64_t& count : *counts) count += next();
  }
  missing_ += next();
  return {};
}

CellInterval VolumeStatistics::range() const {
  const auto used = [](uint64_t count) { return count > 0; };
  const auto first = std::find_if(voxels_.begin(), voxels_.end(), used);
  if (first == voxels_.end()) return {};
  const auto last = std::find_if(voxels_.rbegin(), voxels_.rend(), used);
  return {static_cast<QuantizedValue>(first - voxels_.begin()),
          static_cast<QuantizedValue>(voxels_.rend() - last - 1)};
}

std::vector<uint64_t> VolumeStatistics::histogram(const QuantizedBins& bins) const {
  std::vector<uint64_t> counts(bins.count);
  const auto end = std::min<size_t>(kQuantizedValues, bins.first + size_t{bins.width} * bins.count);
  for (size_t quantized = bins.first; quantized < end; ++quantized) {
    counts[(quantized - bins.first) / bins.width] += voxels_[quantized];
  }
  return counts;
}

std::vector<uint64_t> VolumeStatistics::active_cells(const QuantizedBins& bins) const {
  std::vector<uint64_t> active(bins.count);
  uint64_t running = 0;
  size_t quantized = 0;
  for (uint32_t bin = 0; bin < bins.count; ++bin) {
    // The middle of the bin. The bin begins half a step below its first quantized value.
    const double quantized_isovalue = bins.first - 0.5 + (bin + 0.5) * bins.width;
    for (; quantized < kQuantizedValues && static_cast<double>(quantized) <= quantized_isovalue;
         ++quantized) {
      running += minima_[quantized] - maxima_[quantized];
    }
    active[bin] = running;
  }
  return active;
}

std::vector<double> VolumeStatistics::suggest(CellInterval range, size_t most) const {
  std::vector<double> suggestions;
  if (range.min == range.max) return suggestions;
  constexpr uint32_t kBins = 128;
  const uint32_t bins = std::min<uint32_t>(kBins, range.max - range.min);
  const double width = static_cast<double>(range.max - range.min) / bins;
  // Mean span of the active cells at each bin's middle, and how many there are.
  std::vector<double> steepness(bins), size(bins);
  uint64_t cells = 0, spans = 0;
  uint32_t quantized = range.min;
  double largest = 0;
  for (uint32_t bin = 0; bin < bins; ++bin) {
    const double quantized_isovalue = range.min + (bin + 0.5) * width;
    for (; quantized <= range.max && quantized <= quantized_isovalue; ++quantized) {
      cells += minima_[quantized] - maxima_[quantized];
      spans += spans_from_[quantized] - spans_to_[quantized];
    }
    size[bin] = static_cast<double>(cells);
    steepness[bin] = cells ? static_cast<double>(spans) * kSpanStride / size[bin] : 0;
    largest = std::max(largest, size[bin]);
  }
  // Steep surfaces are boundaries of objects. Very small ones are specks, so the size has a small
  // weight.
  std::vector<double> score(bins);
  for (uint32_t bin = 0; bin < bins; ++bin) {
    double smooth = 0, weight = 0;
    for (int32_t d = -2; d <= 2; ++d) {
      const int32_t at = static_cast<int32_t>(bin) + d;
      if (at < 0 || at >= static_cast<int32_t>(bins)) continue;
      const double w = 3 - std::abs(d);
      smooth += w * steepness[static_cast<size_t>(at)];
      weight += w;
    }
    score[bin] = smooth / weight * std::sqrt(size[bin] / std::max(largest, 1.0));
  }
  std::vector<uint32_t> peaks;
  for (uint32_t bin = 0; bin < bins; ++bin) {
    const bool rises = bin == 0 || score[bin] > score[bin - 1];
    const bool falls = bin + 1 == bins || score[bin] >= score[bin + 1];
    if (rises && falls && score[bin] > 0) peaks.push_back(bin);
  }
  std::stable_sort(peaks.begin(), peaks.end(),
                   [&](uint32_t a, uint32_t b) { return score[a] > score[b]; });
  for (const uint32_t bin : peaks) {
    const double quantized_isovalue = range.min + (bin + 0.5) * width;
    const bool is_near = std::any_of(suggestions.begin(), suggestions.end(), [&](double other) {
      return std::abs(other - quantized_isovalue) < 0.06 * (range.max - range.min);
    });
    if (!is_near) suggestions.push_back(quantized_isovalue);
    if (suggestions.size() == most) break;
  }
  return suggestions;
}

}  // namespace isosplat
