#include "shared/core/codec/predictor_fit.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace isosplat {
namespace {

/// The fitted weights of a class cost about ten bytes. A class with fewer points than this does not
/// save as many bytes by them.
constexpr uint32_t kMinPoints = 300;
constexpr uint32_t kMinSamples = 40;

/// The penalty for the distance from the default weights, relative to a sample of average energy.
constexpr double kRidge = 4;

/// The fit's unknowns are the weights of all taps but the implied one.
constexpr int kUnknowns = kTaps - 1;

/// Weights of this size or more do not come from a sensible fit, and the header could not hold
/// them.
constexpr double kWeightLimit = 7;

/// The tap of an unknown. The point's value follows the last unknown.
constexpr int tap(int unknown) {
  return unknown < kImpliedTap ? unknown : unknown + 1;
}

/// Eight lanes on all machines, because the order of additions changes the sums.
using Lanes = float __attribute__((vector_size(32)));
using IntLanes = int32_t __attribute__((vector_size(32)));
using ShortLanes = int16_t __attribute__((vector_size(16)));

/// A system of linear equations: coefficients, and the right side in the last column.
using System = double[kUnknowns][kUnknowns + 1];

/// Solves a symmetric positive definite system by Gaussian elimination, which needs no pivoting
/// then. Returns false if a solution is not a number below kWeightLimit. Overwrites the system.
bool solve_system(System& a, double (&solution)[kUnknowns]) {
  for (int i = 0; i < kUnknowns; ++i) {
    const double inverse = 1 / a[i][i];
    for (int k = i + 1; k < kUnknowns; ++k) {
      const double factor = a[k][i] * inverse;
      for (int j = i; j <= kUnknowns; ++j) a[k][j] -= factor * a[i][j];
    }
  }
  bool sane = true;
  for (int i = kUnknowns - 1; i >= 0; --i) {
    double sum = a[i][kUnknowns];
    for (int j = i + 1; j < kUnknowns; ++j) sum -= a[i][j] * solution[j];
    solution[i] = sum / a[i][i];
    sane &= std::abs(solution[i]) < kWeightLimit;  // also false for NaN
  }
  return sane;
}

/// Rounds a solution to weights; the implied tap gets the rest of their sum.
void set_weights(const double (&solution)[kUnknowns], int32_t (&taps)[kTaps]) {
  int32_t rest = 1 << kWeightBits;
  for (int i = 0; i < kUnknowns; ++i) {
    const auto weight = static_cast<int32_t>(std::floor(solution[i] * (1 << kWeightBits) + 0.5));
    taps[tap(i)] = weight;
    rest -= weight;
  }
  taps[kImpliedTap] = rest;
}

}  // namespace

/// Sums of the products of each two slots over a class's samples. Only the upper triangle is
/// computed, in tiles of 8×8.
class PredictorFit::Moments {
 public:
  /// samples: kSlots numbers each.
  void add(const float* samples, size_t count) {
    add_tile(samples, count, 0, 0);
    add_tile(samples, count, 0, 8);
    add_tile(samples, count, 8, 8);
  }

  /// Sets up the normal equations of a class, with the penalty (count: samples). Returns false if
  /// all samples are zero.
  bool set_up(System& a, const int16_t* default_weights, size_t count) const {
    const auto product = [&](int i, int j) {
      return static_cast<double>(at(slot_of_tap(tap(i)), slot_of_tap(tap(j))));
    };
    double trace = 0;
    for (int i = 0; i < kUnknowns; ++i) trace += product(i, i);
    if (!(trace > 0)) return false;
    const double ridge = kRidge * trace / kUnknowns / static_cast<double>(count);
    for (int i = 0; i < kUnknowns; ++i) {
      for (int j = 0; j <= kUnknowns; ++j) a[i][j] = product(i, j);
      a[i][i] += ridge;
      a[i][kUnknowns] += ridge * default_weights[tap(i)] / (1 << kWeightBits);
    }
    return true;
  }

 private:
  float at(int i, int j) const { return i <= j ? product_[i][j] : product_[j][i]; }

  /// Eight rows and eight columns: as many sums as fit into registers.
  void add_tile(const float* samples, size_t count, int row, int column) {
    Lanes sums[8];
    for (int i = 0; i < 8; ++i) std::memcpy(&sums[i], &product_[row + i][column], sizeof sums[i]);
    for (size_t s = 0; s < count; ++s) {
      Lanes columns;
      std::memcpy(&columns, samples + s * kSlots + column, sizeof columns);
      for (int i = 0; i < 8; ++i) sums[i] += samples[s * kSlots + row + i] * columns;
    }
    for (int i = 0; i < 8; ++i) std::memcpy(&product_[row + i][column], &sums[i], sizeof sums[i]);
  }

  float product_[kSlots][kSlots] = {};
};

/// Subtracts the implied tap from a sample's slots, so that the weights need not sum to 1 in the
/// fit.
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

/// Fills sorted_. end: receives the end of each class in it.
void PredictorFit::sort_by_class(size_t (&end)[kClasses]) {
  size_t next[kClasses + 1] = {};
  for (const Sample& sample : samples_) ++next[sample.point_class + 1];
  for (int c = 0; c < kClasses; ++c) next[c + 1] += next[c];
  sorted_.resize(samples_.size());
  for (size_t i = 0; i < samples_.size(); ++i) {
    sorted_[next[samples_[i].point_class]++] = static_cast<uint32_t>(i);
  }
  std::copy_n(next, kClasses, end);
}

/// The moments of samples sorted_[begin] to sorted_[end − 1].
PredictorFit::Moments PredictorFit::moments_of(size_t begin, size_t end) const {
  Moments moments;
  constexpr size_t kBatch = 128;  // fits the L1 cache
  float numbers[kBatch * kSlots];
  for (size_t from = begin; from < end; from += kBatch) {
    const size_t count = std::min(kBatch, end - from);
    for (size_t i = 0; i < count; ++i) {
      differences(samples_[sorted_[from + i]].slot, numbers + i * kSlots);
    }
    moments.add(numbers, count);
  }
  return moments;
}

PredictorFit::Weights PredictorFit::solve(uint32_t stride) {
  size_t end[kClasses];
  sort_by_class(end);
  Weights weights;
  for (int c = 0; c < kClasses; ++c) {
    for (int i = 0; i < kTaps; ++i) weights.taps[c][i] = kDefaultWeights[c][i];
    const size_t begin = c > 0 ? end[c - 1] : 0, count = end[c] - begin;
    if (count < kMinSamples || count * uint64_t{stride} < kMinPoints) continue;
    System system;
    double solution[kUnknowns];
    if (!moments_of(begin, end[c]).set_up(system, kDefaultWeights[c], count)) continue;
    if (!solve_system(system, solution)) continue;
    set_weights(solution, weights.taps[c]);
    weights.fitted |= 1u << c;
  }
  return weights;
}

}  // namespace isosplat
