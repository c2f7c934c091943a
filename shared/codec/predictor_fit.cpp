#include "shared/codec/predictor_fit.h"

#include <cmath>
#include <cstring>

namespace isosplat {
namespace {

/// A class's own weights cost some ten bytes: fewer points than this do not earn them back.
constexpr uint32_t kMinPoints = 300;
constexpr uint32_t kMinSamples = 40;

/// Weight of the default weights, as samples of average energy.
constexpr double kRidge = 4;

}  // namespace

void PredictorFit::clear() {
  std::memset(moments_, 0, sizeof moments_);
}

void PredictorFit::add(uint32_t point_class, const int32_t* taps, int32_t value) {
  float difference[16] = {};
  for (int i = 0, k = 0; i < kTaps; ++i) {
    if (i != kImpliedTap) difference[k++] = static_cast<float>(taps[i] - taps[kImpliedTap]);
  }
  difference[kUnknowns] = static_cast<float>(value - taps[kImpliedTap]);
  Moments& moments = moments_[point_class];
  ++moments.count;
  for (int i = 0; i < kUnknowns; ++i) {
    for (int j = 0; j < 16; ++j) moments.product[i][j] += difference[i] * difference[j];
  }
}

PredictorFit::Weights PredictorFit::solve(uint32_t stride) const {
  Weights weights;
  for (int c = 0; c < kClasses; ++c) {
    for (int i = 0; i < kTaps; ++i) weights.taps[c][i] = kDefaultWeights[c][i];
    const Moments& moments = moments_[c];
    if (moments.count < kMinSamples || moments.count * uint64_t{stride} < kMinPoints) continue;

    constexpr int n = kUnknowns;
    double trace = 0;
    for (int i = 0; i < n; ++i) trace += static_cast<double>(moments.product[i][i]);
    if (!(trace > 0)) continue;
    const double ridge = kRidge * trace / n / moments.count;
    double a[n][n + 1];
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= n; ++j) a[i][j] = static_cast<double>(moments.product[i][j]);
      a[i][i] += ridge;
      a[i][n] += ridge * kDefaultWeights[c][i < kImpliedTap ? i : i + 1] / (1 << kWeightBits);
    }
    // Symmetric and positive definite: elimination needs no pivoting.
    for (int i = 0; i < n; ++i) {
      const double inverse = 1 / a[i][i];
      for (int k = i + 1; k < n; ++k) {
        const double factor = a[k][i] * inverse;
        for (int j = i; j <= n; ++j) a[k][j] -= factor * a[i][j];
      }
    }
    double solution[n];
    bool sane = true;
    for (int i = n - 1; i >= 0; --i) {
      double sum = a[i][n];
      for (int j = i + 1; j < n; ++j) sum -= a[i][j] * solution[j];
      solution[i] = sum / a[i][i];
      sane &= std::abs(solution[i]) < 7;  // also false for NaN
    }
    if (!sane) continue;
    int32_t rest = 1 << kWeightBits;
    for (int i = 0; i < n; ++i) {
      const auto weight = static_cast<int32_t>(std::floor(solution[i] * (1 << kWeightBits) + 0.5));
      weights.taps[c][i < kImpliedTap ? i : i + 1] = weight;
      rest -= weight;
    }
    weights.taps[c][kImpliedTap] = rest;
    weights.fitted |= 1u << c;
  }
  return weights;
}

}  // namespace isosplat
