#include "shared/core/points/lattice_gradients.h"

namespace isosplat {
namespace {

constexpr uint32_t kLast = kBlockCells - 1;

/// Whether a cell has a corner on the border of a block of kBlockCells cells along each axis.
bool is_at_border(uint32_t cell) {
  const auto is_end = [](uint32_t index) { return index == 0 || index == kLast; };
  return is_end(cell & 63) || is_end(cell >> 6 & 63) || is_end(cell >> 12 & 63);
}

/// Appends a lattice point to the lists of all neighbours that share it.
void append(BlockBorder& border, Index3 at, const std::array<int32_t, 3>& sum) {
  const auto side = [](int32_t index) { return index == 0 ? -1 : index == kBlockCells ? 1 : 0; };
  const Index3 sides{side(at.x), side(at.y), side(at.z)};
  const auto point = static_cast<uint32_t>(at.x | at.y << 7 | at.z << 14);
  for (int choice = 1; choice < 8; ++choice) {
    const Index3 offset{choice & 1 ? sides.x : 0, choice & 2 ? sides.y : 0,
                        choice & 4 ? sides.z : 0};
    // A choice of axes stands for the neighbour in these directions. It shares the point if the
    // point is at an end of the block along all of them.
    const bool is_shared = !(choice & 1 && sides.x == 0) && !(choice & 2 && sides.y == 0) &&
                           !(choice & 4 && sides.z == 0);
    if (is_shared) border[direction_index(offset)].push_back({point, sum});
  }
}

}  // namespace

LatticeGradients::LatticeGradients() : sums_(kPoints * kPoints * kPoints) {}

void LatticeGradients::add_cell(uint32_t cell, const CellCorners& corners) {
  Sum* const first = &sums_[first_corner(cell)];
  for (int corner = 0; corner < 8; ++corner) {
    // At a corner, the derivatives of the trilinear function are the differences along its edges.
    const auto along = [&](int axis) {
      return int32_t{corners[static_cast<size_t>(corner | axis)]} -
             int32_t{corners[static_cast<size_t>(corner & ~axis)]};
    };
    Sum& sum = first[corner_offset(corner)];
    sum.x += along(1);
    sum.y += along(2);
    sum.z += along(4);
  }
}

void LatticeGradients::add(const DecodedCells& cells) {
  for (size_t i = 0; i < cells.cell.size(); ++i) add_cell(cells.cell[i], cells.corners[i]);
}

void LatticeGradients::remove(const DecodedCells& cells) {
  for (const uint32_t cell : cells.cell) {
    Sum* const first = &sums_[first_corner(cell)];
    for (int corner = 0; corner < 8; ++corner) first[corner_offset(corner)] = {};
  }
}

template <class F>
void LatticeGradients::for_border(const BlockBorder& neighbour, Index3 offset, const F& f) {
  const Index3 back{-offset.x, -offset.y, -offset.z};
  for (const LatticeGradient& gradient : neighbour[direction_index(back)]) {
    const auto from = [&](int shift, int32_t blocks) {
      return static_cast<size_t>(static_cast<int32_t>(gradient.point >> shift & 127) +
                                 blocks * kBlockCells);
    };
    const size_t at =
        from(0, offset.x) + kPoints * (from(7, offset.y) + kPoints * from(14, offset.z));
    f(sums_[at], gradient);
  }
}

void LatticeGradients::add(const BlockBorder& neighbour, Index3 offset) {
  for_border(neighbour, offset, [](Sum& sum, const LatticeGradient& gradient) {
    sum.x += gradient.sum[0];
    sum.y += gradient.sum[1];
    sum.z += gradient.sum[2];
  });
}

void LatticeGradients::remove(const BlockBorder& neighbour, Index3 offset) {
  for_border(neighbour, offset, [](Sum& sum, const LatticeGradient&) { sum = {}; });
}

BlockBorder LatticeGradients::border_of(const DecodedCells& cells) {
  BlockBorder border;
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    if (is_at_border(cells.cell[i])) add_cell(cells.cell[i], cells.corners[i]);
  }
  for (const uint32_t cell : cells.cell) {
    if (!is_at_border(cell)) continue;
    Sum* const first = &sums_[first_corner(cell)];
    for (int corner = 0; corner < 8; ++corner) {
      Sum& sum = first[corner_offset(corner)];
      if (sum.x == 0 && sum.y == 0 && sum.z == 0) continue;
      const Index3 at{static_cast<int32_t>(cell & 63) + (corner & 1),
                      static_cast<int32_t>(cell >> 6 & 63) + (corner >> 1 & 1),
                      static_cast<int32_t>(cell >> 12 & 63) + (corner >> 2)};
      append(border, at, {sum.x, sum.y, sum.z});
      sum = {};  // each point once
    }
  }
  return border;
}

Vec3f LatticeGradients::at(uint32_t cell, Vec3f in_cell) const {
  const Sum* const first = &sums_[first_corner(cell)];
  Vec3f gradient;
  for (int corner = 0; corner < 8; ++corner) {
    const Sum& sum = first[corner_offset(corner)];
    const float weight = (corner & 1 ? in_cell.x : 1 - in_cell.x) *
                         (corner & 2 ? in_cell.y : 1 - in_cell.y) *
                         (corner & 4 ? in_cell.z : 1 - in_cell.z);
    gradient = gradient + Vec3f{static_cast<float>(sum.x), static_cast<float>(sum.y),
                                static_cast<float>(sum.z)} *
                              weight;
  }
  return gradient;
}

}  // namespace isosplat
