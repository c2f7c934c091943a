#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/grid/voxel_type.h"

namespace isosplat::import {

/// The attributes of an array in a file, which follow netCDF's conventions.
class ArrayAttributes {
 public:
  virtual ~ArrayAttributes() = default;

  /// The numbers of an attribute; nothing if it does not exist or is not numeric.
  virtual std::optional<std::vector<double>> numbers(std::string_view name) const = 0;
  /// The type of these numbers.
  virtual std::optional<VoxelType> number_type(std::string_view name) const = 0;
  /// The text of an attribute; empty if there is none.
  virtual std::string text(std::string_view name) const = 0;

 protected:
  ArrayAttributes() = default;
  ArrayAttributes(const ArrayAttributes&) = default;
  ArrayAttributes& operator=(const ArrayAttributes&) = default;
};

}  // namespace isosplat::import
