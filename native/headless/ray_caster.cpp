#include "native/headless/ray_caster.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

constexpr int32_t kBrick = 8;

/// Traverses the cells of a grid with unit spacing along a ray (Amanatides and Woo 1987).
struct Walk {
  Index3 at, step;
  Vec3d next, delta;  // ray parameters of the next face along each axis, and between faces

  Walk(Vec3d origin, Vec3d direction, double t, Index3 low, Index3 high) {
    const auto axis = [&](double o, double d, int32_t lo, int32_t hi, int32_t& i, int32_t& s,
                          double& n, double& dt) {
      i = std::clamp(static_cast<int32_t>(std::floor(o + t * d)), lo, hi - 1);
      s = d > 0 ? 1 : -1;
      n = d != 0 ? ((d > 0 ? i + 1 : i) - o) / d : HUGE_VAL;
      dt = d != 0 ? std::abs(1 / d) : HUGE_VAL;
    };
    axis(origin.x, direction.x, low.x, high.x, at.x, step.x, next.x, delta.x);
    axis(origin.y, direction.y, low.y, high.y, at.y, step.y, next.y, delta.y);
    axis(origin.z, direction.z, low.z, high.z, at.z, step.z, next.z, delta.z);
  }

  /// Ray parameter at which the ray leaves the current cell.
  double leave() const { return std::min({next.x, next.y, next.z}); }

  void advance() {
    if (next.x <= next.y && next.x <= next.z) {
      at.x += step.x;
      next.x += delta.x;
    } else if (next.y <= next.z) {
      at.y += step.y;
      next.y += delta.y;
    } else {
      at.z += step.z;
      next.z += delta.z;
    }
  }

  bool inside(Index3 low, Index3 high) const {
    return at.x >= low.x && at.y >= low.y && at.z >= low.z && at.x < high.x && at.y < high.y &&
           at.z < high.z;
  }
};

/// The smallest root in [lo, hi] of k[3] t³ + k[2] t² + k[1] t + k[0]. Between its extrema the
/// cubic is monotonic: secants and bisection find the root there.
std::optional<double> first_root(const double (&k)[4], double lo, double hi) {
  const auto f = [&](double t) { return ((k[3] * t + k[2]) * t + k[1]) * t + k[0]; };
  double bounds[4] = {lo, hi, hi, hi};
  int parts = 1;
  const double discriminant = k[2] * k[2] - 3 * k[3] * k[1];
  if (discriminant > 0) {
    const double q = -(k[2] + std::copysign(std::sqrt(discriminant), k[2]));
    double r0 = k[3] != 0 ? q / (3 * k[3]) : hi, r1 = q != 0 ? k[1] / q : hi;
    if (r0 > r1) std::swap(r0, r1);
    for (const double r : {r0, r1}) {
      if (r > lo && r < hi) bounds[parts++] = r;
    }
    bounds[parts] = hi;
  }
  for (int i = 0; i < parts; ++i) {
    double a = bounds[i], b = bounds[i + 1], fa = f(a), fb = f(b);
    if ((fa > 0) == (fb > 0)) continue;
    for (int n = 0; n < 100 && b - a > 1e-12; ++n) {
      double t = n % 3 == 2 ? 0.5 * (a + b) : (a * fb - b * fa) / (fb - fa);
      if (!(t > a && t < b)) t = 0.5 * (a + b);
      const double ft = f(t);
      if ((ft > 0) == (fa > 0)) {
        a = t;
        fa = ft;
      } else {
        b = t;
        fb = ft;
      }
    }
    return 0.5 * (a + b);
  }
  return std::nullopt;
}

}  // namespace

RayCaster::RayCaster(const VolumeGrid& grid, std::span<const QuantizedValue> quantized_values,
                     bool has_missing)
    : grid_(grid),
      dual_edges_(grid.dual_edges()),
      quantized_values_(quantized_values),
      has_missing_(has_missing) {
  const Index3 cells{grid.voxels.x - 1, grid.voxels.y - 1, grid.voxels.z - 1};
  bricks_ = {(cells.x + kBrick - 1) / kBrick, (cells.y + kBrick - 1) / kBrick,
             (cells.z + kBrick - 1) / kBrick};
  brick_.assign(size_t(bricks_.x) * size_t(bricks_.y) * size_t(bricks_.z), {65535, 0});
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      for (int32_t x = 0; x < cells.x; ++x) {
        const CellInterval cell = cell_interval({x, y, z});
        if (cell.min >= cell.max) continue;
        CellInterval& brick = brick_[size_t(x / kBrick) +
                                     size_t(bricks_.x) * (size_t(y / kBrick) +
                                                          size_t(bricks_.y) * size_t(z / kBrick))];
        brick.min = std::min(brick.min, cell.min);
        brick.max = std::max(brick.max, cell.max);
      }
    }
  }
}

CellInterval RayCaster::cell_interval(Index3 cell) const {
  const size_t nx = size_t(grid_.voxels.x), nxy = nx * size_t(grid_.voxels.y);
  const QuantizedValue* v =
      &quantized_values_[size_t(cell.x) + nx * size_t(cell.y) + nxy * size_t(cell.z)];
  const CellCorners corners{v[0],   v[1],       v[nx],       v[nx + 1],
                            v[nxy], v[nxy + 1], v[nxy + nx], v[nxy + nx + 1]};
  const CellInterval interval = corner_interval(corners);
  if (has_missing_ && interval.max == kMissingVoxel) return {0, 0};
  return interval;
}

std::optional<RayCaster::Hit> RayCaster::cast(const render::Camera& camera, int width, int height,
                                              int x, int y, double quantized_isovalue) const {
  const render::CameraFrame frame = render::camera_frame(camera);
  const double px = 2 * frame.half_height(1) / height;
  const Vec3d across =
      frame.right * ((x + 0.5 - 0.5 * width) * px) + frame.up * ((y + 0.5 - 0.5 * height) * px);
  const auto in_cells = [&](Vec3d v) { return multiply_transposed(dual_edges_, v); };
  if (frame.orthographic) {
    // The ray begins in front of the whole volume.
    const render::BoundingSphere volume = render::bounding_sphere(grid_);
    const double before =
        std::min(0.0, dot(volume.centre - frame.eye, frame.forward) - 1.01 * volume.radius);
    const Vec3d from = frame.eye + across + frame.forward * before;
    auto hit = cast_ray(in_cells(from - grid_.origin), in_cells(frame.forward), quantized_isovalue);
    if (hit) hit->depth += before;
    return hit;
  }
  const Vec3d direction = frame.forward + across;
  return cast_ray(in_cells(frame.eye - grid_.origin), in_cells(direction), quantized_isovalue);
}

std::optional<RayCaster::Hit> RayCaster::intersect_cell(Index3 c, Vec3d o, Vec3d r, double t,
                                                        double leave,
                                                        double quantized_isovalue) const {
  const size_t nx = size_t(grid_.voxels.x), nxy = nx * size_t(grid_.voxels.y);
  const QuantizedValue* v = &quantized_values_[size_t(c.x) + nx * size_t(c.y) + nxy * size_t(c.z)];
  double k[8] = {double(v[0]),   double(v[1]),       double(v[nx]),       double(v[nx + 1]),
                 double(v[nxy]), double(v[nxy + 1]), double(v[nxy + nx]), double(v[nxy + nx + 1])};
  for (int axis = 1; axis < 8; axis *= 2) {
    for (int i = 7; i >= 0; --i) {
      if (i & axis) k[i] -= k[i - axis];
    }
  }
  // Relative to the entry point, so that the terms stay small.
  const Vec3d p = o + r * t - Vec3d{double(c.x), double(c.y), double(c.z)};
  const double cubic[4] = {k[0] + k[1] * p.x + k[2] * p.y + k[4] * p.z + k[3] * p.x * p.y +
                               k[5] * p.x * p.z + k[6] * p.y * p.z + k[7] * p.x * p.y * p.z -
                               quantized_isovalue,
                           k[1] * r.x + k[2] * r.y + k[4] * r.z + k[3] * (p.x * r.y + r.x * p.y) +
                               k[5] * (p.x * r.z + r.x * p.z) + k[6] * (p.y * r.z + r.y * p.z) +
                               k[7] * (p.x * p.y * r.z + p.x * r.y * p.z + r.x * p.y * p.z),
                           k[3] * r.x * r.y + k[5] * r.x * r.z + k[6] * r.y * r.z +
                               k[7] * (p.x * r.y * r.z + r.x * p.y * r.z + r.x * r.y * p.z),
                           k[7] * r.x * r.y * r.z};
  if (const auto root = first_root(cubic, 0, leave - t)) {
    const Vec3d at = p + r * *root;
    const Vec3d gradient =
        multiply(dual_edges_, {k[1] + k[3] * at.y + k[5] * at.z + k[7] * at.y * at.z,
                               k[2] + k[3] * at.x + k[6] * at.z + k[7] * at.x * at.z,
                               k[4] + k[5] * at.x + k[6] * at.y + k[7] * at.x * at.y});
    const double size = length(gradient);
    return Hit{t + *root, size > 0 ? gradient * (1 / size) : Vec3d{}, size};
  }
  return std::nullopt;
}

std::optional<RayCaster::Hit> RayCaster::cast_ray(Vec3d o, Vec3d r,
                                                  double quantized_isovalue) const {
  const Index3 cells{grid_.voxels.x - 1, grid_.voxels.y - 1, grid_.voxels.z - 1};
  double t0 = 0, t1 = HUGE_VAL;
  const auto clip_axis = [&](double from, double along, double size) {
    if (along == 0) {
      if (from < 0 || from > size) t1 = -1;
      return;
    }
    const double a = -from / along, b = (size - from) / along;
    t0 = std::max(t0, std::min(a, b));
    t1 = std::min(t1, std::max(a, b));
  };
  clip_axis(o.x, r.x, cells.x);
  clip_axis(o.y, r.y, cells.y);
  clip_axis(o.z, r.z, cells.z);
  if (!(t0 < t1)) return std::nullopt;

  const double inverse = 1.0 / kBrick;
  for (Walk brick(o * inverse, r * inverse, t0, {0, 0, 0}, bricks_);
       brick.inside({0, 0, 0}, bricks_); brick.advance()) {
    const double brick_leave = std::min(brick.leave(), t1);
    const CellInterval range =
        brick_[size_t(brick.at.x) +
               size_t(bricks_.x) * (size_t(brick.at.y) + size_t(bricks_.y) * size_t(brick.at.z))];
    if (range.min <= quantized_isovalue && quantized_isovalue < range.max) {
      const Index3 low{brick.at.x * kBrick, brick.at.y * kBrick, brick.at.z * kBrick};
      const Index3 high{std::min(low.x + kBrick, cells.x), std::min(low.y + kBrick, cells.y),
                        std::min(low.z + kBrick, cells.z)};
      double t = t0;
      for (Walk walk(o, r, t0, low, high); walk.inside(low, high); walk.advance()) {
        const double leave = std::min(walk.leave(), t1);
        const Index3 c = walk.at;
        const CellInterval interval = cell_interval(c);
        if (leave > t && interval.min <= quantized_isovalue && quantized_isovalue < interval.max) {
          if (auto hit = intersect_cell(c, o, r, t, leave, quantized_isovalue)) return hit;
        }
        t = std::max(t, leave);
        if (t >= brick_leave - 1e-12 && leave >= brick_leave) break;
      }
    }
    t0 = std::max(t0, brick_leave);
    if (t0 >= t1) break;
  }
  return std::nullopt;
}

}  // namespace isosplat
