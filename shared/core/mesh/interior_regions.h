#pragma once

#include <array>
#include <cstdint>

namespace isosplat {

/// The least number of each element's set, for up to 32 elements.
template <int N>
class SmallSets {
 public:
  SmallSets() {
    for (int i = 0; i < N; ++i) parent_[i] = static_cast<uint8_t>(i);
  }
  int find(int i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  void unite(int a, int b) {
    a = find(a);
    b = find(b);
    if (a < b) parent_[b] = static_cast<uint8_t>(a);
    if (b < a) parent_[a] = static_cast<uint8_t>(b);
  }

 private:
  std::array<uint8_t, N> parent_;
};

/// For each corner of a cell, a number of the part of the cell that contains it: the parts in which
/// the trilinear function is above 0, and those in which it is not. Corners have the same number if
/// a path through the cell connects them that stays on one side. values: of the corners, minus the
/// isovalue.
///
/// Every part of a plane slice contains a corner of the slice, since the bilinear function on it
/// has no extremum inside. So it is enough to follow the corners of the slices along z, and to find
/// between which slices diagonal corners are connected (E. V. Chernyaev, "Marching Cubes 33", 1995,
/// tests one slice of them).
std::array<int, 8> interior_regions(const std::array<double, 8>& values);

}  // namespace isosplat
