#pragma once

#include <bit>
#include <cstddef>
#include <span>
#include <vector>

#include "shared/core/grid/grid.h"

// The bytes of NumPy's arrays of points.
namespace isosplat {

static_assert(std::endian::native == std::endian::little, "the file has the layout of memory");

template <class T>
void append_bytes(const T& value, std::vector<std::byte>& out) {
  const auto bytes = std::as_bytes(std::span(&value, 1));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

/// Three numbers, of double precision if `has_doubles`, otherwise of single precision.
inline void append_position(const Vec3d& at, bool has_doubles, std::vector<std::byte>& out) {
  if (has_doubles) {
    append_bytes(at, out);
  } else {
    append_bytes(
        Vec3f{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)}, out);
  }
}

}  // namespace isosplat
