#include "native/builder/signed_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace isosplat {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The squared distances along one axis, row by row. Between two passes, a voxel has its squared
/// distance from the other side in the part of the volume that the passes have seen, negative
/// inside. So one number suffices: the distance from the voxel's own side is 0.
class RowPass {
 public:
  RowPass(int32_t voxels, double spacing)
      : spacing_(spacing), row_(static_cast<size_t>(voxels)), result_(row_.size()) {
    sites_.reserve(row_.size() + 1);
  }

  std::vector<double>& row() { return row_; }

  /// Replaces the row.
  void run() {
    std::fill(result_.begin(), result_.end(), 0.0);
    add_side(1);
    add_side(-1);
    row_.swap(result_);
  }

 private:
  /// A parabola that is the lowest from `from` on. Positions are those of centres, times 1.
  struct Site {
    double at, height, from;
  };

  /// The height of a voxel above 0, of the function that is 0 on the other side.
  double height(size_t voxel, double side) const { return std::max(side * row_[voxel], 0.0); }

  /// Sets the distances of the voxels of one side: 1, outside, or −1.
  void add_side(double side) {
    // Along the row, the nearest point of a voxel's box is on one of its faces, or at the centre
    // itself. The function of a face is that of the lower voxel beside it.
    const size_t n = row_.size();
    sites_.clear();
    for (size_t face = 0; face <= n; ++face) {
      const double before = face > 0 ? height(face - 1, side) : kInfinity;
      const double after = face < n ? height(face, side) : kInfinity;
      const double lower = std::min(before, after);
      if (lower < kInfinity) add(static_cast<double>(face) - 0.5, lower);
    }
    auto site = sites_.begin();
    for (size_t x = 0; x < n; ++x) {
      const double own = height(x, side);
      if (own == 0) continue;  // of the other side
      double lowest = own;
      if (!sites_.empty()) {
        const auto at = static_cast<double>(x);
        while (site + 1 != sites_.end() && (site + 1)->from <= at) ++site;
        const double distance = (at - site->at) * spacing_;
        lowest = std::min(own, site->height + distance * distance);
      }
      result_[x] = side * lowest;
    }
  }

  void add(double at, double height) {
    double from = -kInfinity;
    while (!sites_.empty()) {
      const Site& last = sites_.back();
      // Where both parabolas have the same height.
      from =
          (at + last.at) / 2 + (height - last.height) / (2 * spacing_ * spacing_ * (at - last.at));
      if (from > last.from) break;
      sites_.pop_back();
      from = -kInfinity;
    }
    sites_.push_back({at, height, from});
  }

  double spacing_;
  std::vector<double> row_, result_;
  std::vector<Site> sites_;
};

/// Runs a pass over rows of n voxels, which are `stride` apart. `first`: of the row.
void pass_row(RowPass& pass, float* first, size_t stride) {
  std::vector<double>& row = pass.row();
  for (size_t i = 0; i < row.size(); ++i) row[i] = double{first[i * stride]};
  pass.run();
  for (size_t i = 0; i < row.size(); ++i) first[i * stride] = static_cast<float>(row[i]);
}

}  // namespace

void signed_distances(Index3 size, Vec3d spacing, std::span<float> voxels) {
  // In units of the shortest edge, so that squares are within the range of floats.
  const double unit = std::min({spacing.x, spacing.y, spacing.z});
  const auto nx = static_cast<size_t>(size.x), ny = static_cast<size_t>(size.y),
             nz = static_cast<size_t>(size.z), slice = nx * ny;
  for (float& voxel : voxels) {
    voxel = std::copysign(std::numeric_limits<float>::infinity(), voxel);
  }
  RowPass along_x(size.x, spacing.x / unit);
  for (size_t row = 0; row < ny * nz; ++row) pass_row(along_x, &voxels[row * nx], 1);
  RowPass along_y(size.y, spacing.y / unit);
  for (size_t z = 0; z < nz; ++z) {
    for (size_t x = 0; x < nx; ++x) pass_row(along_y, &voxels[z * slice + x], nx);
  }
  RowPass along_z(size.z, spacing.z / unit);
  for (size_t i = 0; i < slice; ++i) pass_row(along_z, &voxels[i], slice);
  for (float& voxel : voxels) {
    voxel = static_cast<float>(std::copysign(std::sqrt(std::abs(double{voxel})) * unit, voxel));
  }
}

}  // namespace isosplat
