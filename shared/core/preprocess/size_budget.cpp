#include "shared/core/preprocess/size_budget.h"

#include <algorithm>

#include "shared/core/base/portable_math.h"

namespace isosplat {
namespace {

/// kGuard, a share of the allowed bytes, is the limit for every block. λ aims lower by kCaution, a
/// share of the bytes still to be written, because forecasts are inexact.
constexpr double kGuard = 0.98, kCaution = 0.05;

/// The weight of the forecast in the correction before blocks are finished: it counts like blocks
/// of these shares of the smallest forecast, and of the allowed bytes.
constexpr double kTrust = 0.03, kTrustOfMax = 0.003;

/// The upper limit of a volume's size relative to its forecast. The largest measured ratio is 3.3,
/// of a sheared CT.
constexpr double kWorstError = 3.5;

}  // namespace

SizeBudget::SizeBudget(const SizeForecast& forecast, double max_bytes, double fixed_bytes)
    : forecast_(forecast), max_(max_bytes), spent_(fixed_bytes) {
  for (size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    part.remaining = forecast.all(i > 0);
    part.forecast = part.actual = kTrust * part.remaining.back() + kTrustOfMax * max_bytes;
  }
}

double SizeBudget::at(const PerCandidate& bytes, double storage_weight) const {
  const double first = forecast_.storage_weight(0), ratio = forecast_.storage_weight(1) / first;
  const double position =
      ratio > 1 ? portable::log(storage_weight / first) / portable::log(ratio) : 0;
  const double candidate = std::clamp(position, 0.0, double{kCandidateWeights - 1});
  const auto below = std::min(static_cast<size_t>(candidate), kCandidateWeights - 2);
  const double share = candidate - static_cast<double>(below);
  return bytes[below] * (1 - share) + bytes[below + 1] * share;
}

double SizeBudget::total(size_t candidate, const std::array<double, 2>& correction) const {
  double bytes = spent_;
  for (size_t i = 0; i < parts_.size(); ++i)
    bytes += correction[i] * parts_[i].remaining[candidate];
  return bytes;
}

SizeBudget::Grant SizeBudget::grant() const {
  Grant grant;
  for (size_t i = 0; i < parts_.size(); ++i) grant.correction[i] = parts_[i].correction();
  const double goal = kGuard * max_ - kCaution * std::max(kGuard * max_ - spent_, 0.0);
  size_t candidate = 0;
  while (candidate < kCandidateWeights && total(candidate, grant.correction) > goal) ++candidate;
  if (candidate == 0) {
    grant.storage_weight = forecast_.storage_weight(0);
  } else if (candidate == kCandidateWeights) {
    grant.storage_weight = forecast_.storage_weight(kCandidateWeights - 1);
  } else {
    const double above = total(candidate - 1, grant.correction),
                 below = total(candidate, grant.correction);
    const double share = (above - goal) / std::max(above - below, 1e-9);
    grant.storage_weight =
        forecast_.storage_weight(candidate - 1) *
        portable::pow(forecast_.storage_weight(candidate) / forecast_.storage_weight(candidate - 1),
                      share);
  }
  grant.slack = kGuard * max_ - total(kCandidateWeights - 1, grant.correction);
  return grant;
}

bool SizeBudget::is_ample() const {
  const std::array<double, 2> correction = {parts_[0].correction(), parts_[1].correction()};
  return spent_ + kWorstError * (total(0, correction) - spent_) < kGuard * max_;
}

double SizeBudget::min_bytes(const Grant& grant, uint32_t level, Index3 block) const {
  return grant.correction[level > 0] * forecast_.block(level, block).back();
}

void SizeBudget::add(uint32_t level, Index3 block, double storage_weight, double bytes) {
  const PerCandidate forecast = forecast_.block(level, block);
  Part& part = parts_[level > 0];
  for (size_t candidate = 0; candidate < kCandidateWeights; ++candidate)
    part.remaining[candidate] -= forecast[candidate];
  part.forecast += at(forecast, storage_weight);
  part.actual += bytes;
  spent_ += bytes;
}

}  // namespace isosplat
