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
      spans_to_(kQuantizedValues),
      agreement_(kQuantizedValues) {}

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

void VolumeStatistics::add_block(const BandPlanner& planner, const GatheredBlock& block) {
  if (planner.cells() == 0) return;
  const std::vector<CellInterval>& intervals = block.intervals;
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
  agreement_.add(block);
}

void VolumeStatistics::add(const VolumeStatistics& other) {
  const auto sum = [](auto& to, const auto& from) {
    for (size_t i = 0; i < kQuantizedValues; ++i) to[i] += from[i];
  };
  sum(voxels_, other.voxels_);
  sum(minima_, other.minima_);
  sum(maxima_, other.maxima_);
  sum(spans_from_, other.spans_from_);
  sum(spans_to_, other.spans_to_);
  sum(agreement_.cosines, other.agreement_.cosines);
  sum(agreement_.pairs, other.agreement_.pairs);
  missing_ += other.missing_;
}

std::vector<std::byte> VolumeStatistics::bytes() const {
  std::vector<std::byte> all;
  const auto append = [&](std::span<const std::byte> part) {
    all.insert(all.end(), part.begin(), part.end());
  };
  for (const auto* counts : {&voxels_, &minima_, &maxima_, &spans_from_, &spans_to_}) {
    append(std::as_bytes(std::span(*counts)));
  }
  append(std::as_bytes(std::span(agreement_.cosines)));
  append(std::as_bytes(std::span(agreement_.pairs)));
  append(std::as_bytes(std::span(&missing_, 1)));
  return all;
}

Result<void> VolumeStatistics::add(std::span<const std::byte> bytes) {
  if (bytes.size() != (7 * kQuantizedValues + 1) * sizeof(uint64_t)) {
    return fail(Status::invalid_argument,
                "the statistics of an encoder are of another version, or incomplete: load the page "
                "again");
  }
  const std::byte* at = bytes.data();
  const auto add_next = [&at](auto& to) {
    auto number = to;
    std::memcpy(&number, at, sizeof number);
    at += sizeof number;
    to += number;
  };
  for (auto* counts : {&voxels_, &minima_, &maxima_, &spans_from_, &spans_to_}) {
    for (uint64_t& count : *counts) add_next(count);
  }
  for (auto* sums : {&agreement_.cosines, &agreement_.pairs}) {
    for (int64_t& sum : *sums) add_next(sum);
  }
  add_next(missing_);
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

std::vector<SurfaceStatistics> VolumeStatistics::surfaces(
    std::span<const double> quantized_isovalues) const {
  // A few pairs say little: a speck is not the boundary of an object.
  constexpr double kFewPairs = 4;
  std::vector<SurfaceStatistics> surfaces;
  uint64_t cells = 0, spans = 0;
  int64_t cosines = 0, pairs = 0;
  size_t quantized = 0;
  for (const double isovalue : quantized_isovalues) {
    for (; quantized < kQuantizedValues && static_cast<double>(quantized) <= isovalue;
         ++quantized) {
      cells += minima_[quantized] - maxima_[quantized];
      spans += spans_from_[quantized] - spans_to_[quantized];
      cosines += agreement_.cosines[quantized];
      pairs += agreement_.pairs[quantized];
    }
    SurfaceStatistics& surface = surfaces.emplace_back();
    surface.cells = static_cast<double>(cells);
    if (cells > 0) surface.span = static_cast<double>(spans) * kSpanStride / surface.cells;
    surface.agreement = static_cast<double>(cosines) / static_cast<double>(agreement_.kOne) /
                        (static_cast<double>(pairs) + kFewPairs);
  }
  return surfaces;
}

double VolumeStatistics::voxels_between(double low, double high) const {
  const auto above = [](double value) {
    return static_cast<size_t>(std::clamp(std::floor(value) + 1, 0.0, double{kQuantizedValues}));
  };
  uint64_t count = 0;
  for (size_t quantized = above(low); quantized < above(high); ++quantized) {
    count += voxels_[quantized];
  }
  return static_cast<double>(count);
}

}  // namespace isosplat
