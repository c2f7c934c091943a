#include "tests/evidence/sampling/methods.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shared/core/sampling/exact_projection.h"
#include "shared/core/sampling/projection.h"

namespace isosplat {
namespace {

bool crosses(const std::array<float, 8>& corners, float isovalue) {
  const auto [low, high] = std::ranges::minmax(corners);
  return low <= isovalue && isovalue < high;
}

Vec3f centre_of(const SampleBox& box) {
  const float half = box.side / 2;
  return box.low + Vec3f{half, half, half};
}

Vec3f clamped_to_cell(Vec3f p) {
  return {std::clamp(p.x, 0.0f, 1.0f), std::clamp(p.y, 0.0f, 1.0f), std::clamp(p.z, 0.0f, 1.0f)};
}

std::optional<Vec3f> newton_step(const Trilinear& f, Vec3f p, float isovalue) {
  const auto [value, gradient] = f.at(p);
  return project(p, value, gradient, isovalue);
}

}  // namespace

void subdivide(const std::array<float, 8>& corners, float isovalue, Subdivision subdivision,
               float max_interval, std::vector<SampleBox>& boxes) {
  boxes.clear();
  const auto [low, high] = std::ranges::minmax(corners);
  const bool split = subdivision == Subdivision::isotropic ||
                     (subdivision == Subdivision::adaptive && high - low > max_interval);
  if (!split) {
    boxes.push_back({{}, 1, corners});
    return;
  }
  const Trilinear f(corners);
  for (int octant = 0; octant < 8; ++octant) {
    SampleBox box{
        {0.5f * float(octant & 1), 0.5f * float(octant >> 1 & 1), 0.5f * float(octant >> 2)},
        0.5f,
        {}};
    for (int i = 0; i < 8; ++i) {
      const Vec3f corner{0.5f * float(i & 1), 0.5f * float(i >> 1 & 1), 0.5f * float(i >> 2)};
      box.corners[static_cast<size_t>(i)] = f.at(box.low + corner).value;
    }
    if (crosses(box.corners, isovalue)) boxes.push_back(box);
  }
}

std::optional<Vec3f> project_sample(const Trilinear& f, const SampleBox& box, float isovalue,
                                    ProjectionMethod method) {
  const Vec3f from = centre_of(box);
  const float limit = 0.5f * std::numbers::sqrt3_v<float> * box.side;
  if (method == ProjectionMethod::exact) {
    if (const auto root = project_exactly(f, from, f.at(from).gradient, isovalue)) return root;
    method = ProjectionMethod::newton_clamped;
  }
  auto to = newton_step(f, from, isovalue);
  if (to && method == ProjectionMethod::two_newton) to = newton_step(f, *to, isovalue);
  if (method != ProjectionMethod::newton_clamped) {
    return to && length(*to - from) <= limit ? to : std::nullopt;
  }
  if (!to) return from;
  const Vec3f step = *to - from;
  const float size = length(step);
  return clamped_to_cell(size > limit ? from + step * (limit / size) : *to);
}

}  // namespace isosplat
