#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/core/base/vec3.h"

namespace isosplat {

/// The greatest label of a LabelVolume.
inline constexpr uint16_t kMaxLabel = 32766;

/// The labels of voxels, from 0 (also: outside the volume) to kMaxLabel: size.y · size.z rows, x
/// fastest.
struct LabelVolume {
  std::span<const uint16_t> labels;
  Index3 size;

  const uint16_t* row(int32_t y, int32_t z) const {
    const size_t number =
        static_cast<size_t>(z) * static_cast<size_t>(size.y) + static_cast<size_t>(y);
    return labels.data() + number * static_cast<size_t>(size.x);
  }
};

/// The voxels first to first + size − 1 on each axis.
struct LabelBox {
  Index3 first, size;
};

}  // namespace isosplat
