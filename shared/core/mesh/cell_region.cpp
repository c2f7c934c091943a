#include "shared/core/mesh/cell_region.h"

#include <cmath>

namespace isosplat {

CellRegion CellRegion::in_world(const VolumeGrid& grid, Vec3d low, Vec3d high) {
  return {grid.cell_edges(), grid.origin, low, high};
}

CellRegion CellRegion::in_grid(Vec3d low, Vec3d high) {
  return {kIdentity3, {}, low, high};
}

bool CellRegion::contains(Index3 cell, uint32_t level) const {
  const double size = std::ldexp(1.0, static_cast<int>(level));
  const Vec3d centre{size * (cell.x + 0.5), size * (cell.y + 0.5), size * (cell.z + 0.5)};
  const Vec3d at = origin_ + multiply(edges_, centre);
  return at.x >= low_.x && at.x < high_.x && at.y >= low_.y && at.y < high_.y && at.z >= low_.z &&
         at.z < high_.z;
}

bool CellRegion::may_contain(Index3 first, Index3 count, uint32_t level) const {
  const double size = std::ldexp(1.0, static_cast<int>(level));
  const Vec3d half{size / 2 * count.x, size / 2 * count.y, size / 2 * count.z};
  const Vec3d centre = Vec3d{size * first.x, size * first.y, size * first.z} + half;
  const Vec3d at = origin_ + multiply(edges_, centre);
  // The box around the cells, along the axes of the region.
  const auto reach = [&](size_t row) {
    return std::abs(edges_[3 * row]) * half.x + std::abs(edges_[3 * row + 1]) * half.y +
           std::abs(edges_[3 * row + 2]) * half.z;
  };
  const auto overlaps = [](double middle, double radius, double low, double high) {
    return middle + radius >= low && middle - radius < high;
  };
  return overlaps(at.x, reach(0), low_.x, high_.x) && overlaps(at.y, reach(1), low_.y, high_.y) &&
         overlaps(at.z, reach(2), low_.z, high_.z);
}

void CellRegion::keep(DecodedCells& cells, Index3 origin, uint32_t level) const {
  size_t kept = 0;
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    const uint32_t packed = cells.cell[i];
    const Index3 cell{origin.x + static_cast<int32_t>(packed & 63),
                      origin.y + static_cast<int32_t>(packed >> 6 & 63),
                      origin.z + static_cast<int32_t>(packed >> 12 & 63)};
    if (!contains(cell, level)) continue;
    cells.cell[kept] = packed;
    cells.corners[kept] = cells.corners[i];
    cells.interval[kept] = cells.interval[i];
    ++kept;
  }
  cells.cell.resize(kept);
  cells.corners.resize(kept);
  cells.interval.resize(kept);
}

}  // namespace isosplat
