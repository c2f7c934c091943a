#include "shared/codec/predictor_fit.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace isosplat {
namespace {

/// A class's own weights cost some ten bytes: fewer points than this do not earn them back.
constexpr uint32_t kMinPoints = 300;
constexpr uint32_t kMinSamples = 40;

/// Weight of the default weights, as samples of average energy.
constexpr double kRidge = 4;

constexpr int kUnknowns = kTaps - 1;

/// The tap of an unknown; what follows the last is the value.
constexpr int tap(int unknown) {
  return unknown < kImpliedTap ? unknown : unknown + 1;
}

/// Eight lanes, whatever the machine has: it must not matter to the sums.
using Lanes = float __attribute__((vector_size(32)));
using IntLanes = int32_t __attribute__((vector_size(32)));
using ShortLanes = int16_t __attribute__((vector_size(16)));

/// Sums of products of a class's samples: row i, column j where j ≥ i or both are in one half.
class Moments {
 public:
  /// samples: 16 numbers each.
  void add(const float* samples, size_t count) {
    add_tile(samples, count, 0, 0);
    add_tile(samples, count, 0, 8);
    add_tile(samples, count, 8, 8);
  }
  float at(int i, int j) const { return i <= j ? product_[i][j] : product_[j][i]; }

 private:
  /// Eight rows and eight columns: as many sums as fit into registers.
  void add_tile(const float* samples, size_t count, int row, int column) {
    Lanes sums[8];
    for (int i = 0; i < 8; ++i) std::memcpy(&sums[i], &product_[row + i][column], sizeof sums[i]);
    for (size_t s = 0; s < count; ++s) {
      Lanes columns;
      std::memcpy(&columns, samples + s * 16 + column, sizeof columns);
      for (int i = 0; i < 8; ++i) sums[i] += samples[s * 16 + row + i] * columns;
    }
    for (int i = 0; i < 8; ++i) std::memcpy(&product_[row + i][column], &sums[i], sizeof sums[i]);
  }

  float product_[16][16] = {};
};

}  // namespace

/// A sample's slots less the implied tap.
void PredictorFit::differences(const int16_t* slots, float* to) {
  const int32_t implied = slots[kImpliedTap];
  for (int i = 0; i < kSlots; i += 8) {
    ShortLanes eight;
    std::memcpy(&eight, slots + i, sizeof eight);
    const auto difference = __builtin_convertvector(eight, IntLanes) - implied;
    const auto number = __builtin_convertvector(difference, Lanes);
    std::memcpy(to + i, &number, sizeof number);
  }
}

PredictorFit::Weights PredictorFit::solve(uint32_t stride) {
  // Sorted by class.
  size_t end[kClasses + 1] = {};
  for (const Sample& sample : samples_) ++end[sample.point_class + 1];
  for (int c = 0; c < kClasses; ++c) end[c + 1] += end[c];
  sorted_.resize(samples_.size());
  for (size_t i = 0; i < samples_.size(); ++i) {
    sorted_[end[samples_[i].point_class]++] = static_cast<uint32_t>(i);
  }

  Weights weights;
  for (int c = 0; c < kClasses; ++c) {
    for (int i = 0; i < kTaps; ++i) weights.taps[c][i] = kDefaultWeights[c][i];
    const size_t begin = c > 0 ? end[c - 1] : 0, count = end[c] - begin;
    if (count < kMinSamples || count * uint64_t{stride} < kMinPoints) continue;
    Moments moments;
    // As many at a time as stay in the nearest cache.
    constexpr size_t kAtOnce = 128;
    float numbers[kAtOnce * kSlots];
    for (size_t from = begin; from < end[c]; from += kAtOnce) {
      const size_t now = std::min(kAtOnce, end[c] - from);
      for (size_t i = 0; i < now; ++i) {
        differences(samples_[sorted_[from + i]].slot, numbers + i * kSlots);
      }
      moments.add(numbers, now);
    }

    const auto product = [&](int i, int j) {
      return static_cast<double>(moments.at(slot_of_tap(tap(i)), slot_of_tap(tap(j))));
    };
    double trace = 0;
    for (int i = 0; i < kUnknowns; ++i) trace += product(i, i);
    if (!(trace > 0)) continue;
    const double ridge = kRidge * trace / kUnknowns / static_cast<double>(count);
    double a[kUnknowns][kUnknowns + 1];
    for (int i = 0; i < kUnknowns; ++i) {
      for (int j = 0; j <= kUnknowns; ++j) a[i][j] = product(i, j);
      a[i][i] += ridge;
      a[i][kUnknowns] += ridge * kDefaultWeights[c][tap(i)] / (1 << kWeightBits);
    }
    // Symmetric and positive definite: elimination needs no pivoting.
    for (int i = 0; i < kUnknowns; ++i) {
      const double inverse = 1 / a[i][i];
      for (int k = i + 1; k < kUnknowns; ++k) {
        const double factor = a[k][i] * inverse;
        for (int j = i; j <= kUnknowns; ++j) a[k][j] -= factor * a[i][j];
      }
    }
    double solution[kUnknowns];
    bool sane = true;
    for (int i = kUnknowns - 1; i >= 0; --i) {
      double sum = a[i][kUnknowns];
      for (int j = i + 1; j < kUnknowns; ++j) sum -= a[i][j] * solution[j];
      solution[i] = sum / a[i][i];
      sane &= std::abs(solution[i]) < 7;  // also false for NaN
    }
    if (!sane) continue;
    int32_t rest = 1 << kWeightBits;
    for (int i = 0; i < kUnknowns; ++i) {
      const auto weight = static_cast<int32_t>(std::floor(solution[i] * (1 << kWeightBits) + 0.5));
      weights.taps[c][tap(i)] = weight;
      rest -= weight;
    }
    weights.taps[c][kImpliedTap] = rest;
    weights.fitted |= 1u << c;
  }
  return weights;
}

}  // namespace isosplat
