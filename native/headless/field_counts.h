#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shared/core/grid/grid.h"
#include "shared/core/sampling/packed_field.h"
#include "shared/core/sampling/packed_sample.h"

namespace isosplat {

/// Counts the values of a field in the cells of isosurfaces, for the range of a colour map.
class FieldCounts {
 public:
  /// `isovalues`: quantized, of the isosurfaces.
  FieldCounts(const ValueMapping& field, std::span<const float> isovalues);

  /// Adds the mean of the corners of each cell that an isosurface crosses. Cells with a missing
  /// corner count as none. `values`: of the field, one for each sample.
  void add(std::span<const PackedSample> samples, std::span<const PackedField> values);

  /// The first and the 99th percentile of the means, as values of the field. Nothing if there are
  /// none.
  std::optional<std::array<double, 2>> percentiles() const;

 private:
  ValueMapping field_;
  std::vector<float> isovalues_;
  std::vector<uint64_t> counts_;  // by quantized value
};

}  // namespace isosplat
