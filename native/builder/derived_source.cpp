#include "native/builder/derived_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace isosplat {
namespace {

/// The voxels of a central difference along an axis of n voxels: around `at`, or around its
/// neighbour if it is on the border.
struct Stencil {
  int32_t low, middle, high;

  Stencil(int32_t at, int32_t n) {
    middle = n > 2 ? std::clamp(at, 1, n - 2) : at;
    low = std::max(middle - 1, 0);
    high = std::min(middle + 1, n - 1);
  }
  int32_t steps() const { return high - low; }
  bool has_second() const { return steps() == 2; }
};

/// The first and second derivatives of a volume with respect to the voxel index.
struct Derivatives {
  Vec3d gradient;
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  /// vᵀ H v, with the matrix H of second derivatives.
  double second(Vec3d v) const {
    return v.x * v.x * xx + v.y * v.y * yy + v.z * v.z * zz +
           2 * (v.x * v.y * xy + v.x * v.z * xz + v.y * v.z * yz);
  }
};

/// `f`: the value at a voxel. `with_second`: also the second derivatives.
template <class F>
Derivatives derivatives_at(const F& f, const Stencil& x, const Stencil& y, const Stencil& z,
                           bool with_second) {
  const auto first = [](double high, double low, const Stencil& along) {
    return (high - low) / along.steps();
  };
  const auto on_x = [&](int32_t i) { return f(i, y.middle, z.middle); };
  const auto on_y = [&](int32_t j) { return f(x.middle, j, z.middle); };
  const auto on_z = [&](int32_t k) { return f(x.middle, y.middle, k); };
  Derivatives d;
  d.gradient = {first(on_x(x.high), on_x(x.low), x), first(on_y(y.high), on_y(y.low), y),
                first(on_z(z.high), on_z(z.low), z)};
  if (!with_second) return d;
  const auto second = [](const auto& on, const Stencil& along) {
    return along.has_second() ? on(along.high) - 2 * on(along.middle) + on(along.low) : 0;
  };
  d.xx = second(on_x, x);
  d.yy = second(on_y, y);
  d.zz = second(on_z, z);
  const auto mixed = [](const auto& on, const Stencil& a, const Stencil& b) {
    return (on(a.high, b.high) - on(a.high, b.low) - on(a.low, b.high) + on(a.low, b.low)) /
           (a.steps() * b.steps());
  };
  d.xy = mixed([&](int32_t i, int32_t j) { return f(i, j, z.middle); }, x, y);
  d.xz = mixed([&](int32_t i, int32_t k) { return f(i, y.middle, k); }, x, z);
  d.yz = mixed([&](int32_t j, int32_t k) { return f(x.middle, j, k); }, y, z);
  return d;
}

}  // namespace

std::optional<Derived> derived_of(std::string_view text) {
  if (text == "gradient") return Derived::gradient;
  if (text == "curvature") return Derived::curvature;
  return std::nullopt;
}

DerivedSource::DerivedSource(std::unique_ptr<VolumeSource> volume, Derived derived)
    : volume_(std::move(volume)),
      header_(volume_->header()),
      derived_(derived),
      window_(*volume_),
      dual_edges_(header_.grid.dual_edges()) {
  const Vec3d spacing = header_.grid.spacing;
  most_curvature_ = 1 / std::min({spacing.x, spacing.y, spacing.z});
  header_.type = VoxelType::f64;
  header_.slope = 1;
  header_.intercept = 0;
}

double DerivedSource::value(Index3 voxel) const {
  const Index3 n = header_.grid.voxels;
  const auto f = [&](int32_t i, int32_t j, int32_t k) { return window_.at(i, j, k); };
  const Derivatives d = derivatives_at(f, Stencil(voxel.x, n.x), Stencil(voxel.y, n.y),
                                       Stencil(voxel.z, n.z), derived_ == Derived::curvature);
  const Vec3d gradient = multiply(dual_edges_, d.gradient);
  const double magnitude = length(gradient);
  if (derived_ == Derived::gradient) return magnitude;
  if (!(magnitude > 0)) return std::numeric_limits<double>::quiet_NaN();
  double trace = 0;
  for (size_t row = 0; row < 9; row += 3) {
    trace += d.second({dual_edges_[row], dual_edges_[row + 1], dual_edges_[row + 2]});
  }
  const Vec3d normal = multiply_transposed(dual_edges_, gradient * (1 / magnitude));
  const double curvature = (d.second(normal) - trace) / (2 * magnitude);
  return std::clamp(curvature, -most_curvature_, most_curvature_);
}

Result<void> DerivedSource::read_slices(int32_t first, int32_t count, std::span<std::byte> out) {
  const Index3 n = header_.grid.voxels;
  auto* values = reinterpret_cast<double*>(out.data());
  for (int32_t z = first; z < first + count; ++z) {
    const Stencil slices(z, n.z);
    if (auto held = window_.move_to({slices.low, slices.high + 1}); !held) return held;
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) *values++ = value({x, y, z});
    }
  }
  return {};
}

}  // namespace isosplat
