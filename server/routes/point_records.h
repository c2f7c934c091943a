#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/points/chunk_samples.h"

namespace isosplat::server {

enum class PointField : uint8_t { positions, normals, values };

/// One record per point with the chosen fields, little-endian and without padding, as in an array
/// of NumPy. Positions are three numbers in double or single precision. Normals are three numbers
/// and values are one, in single precision.
class PointRecords {
 public:
  /// `fields`: some of "positions,normals,values" in any order, each once. Errors:
  /// invalid_argument.
  static Result<PointRecords> parse(std::string_view fields, bool double_positions);

  /// Adds the value of a field of the store to the end of each record, in single precision. It has
  /// the name of the field, with "_field" appended if another number has this name.
  void add_field(const std::string& name);

  bool has(PointField field) const;

  /// Size of a record in bytes.
  size_t bytes() const;

  /// The dtype in NumPy's notation: a list of fields, even if there is only one.
  std::string dtype() const;

  /// The header of a .npy file (version 1.0) for `count` records; the records follow it. One field
  /// gives an array of the shape (count, 3), or (count) for values; several fields give a
  /// structured array.
  std::string npy_header(uint64_t count) const;

  /// Appends a record for each point. `points` must have the arrays of the fields. field: the
  /// values of the field that was added.
  void append(const PointArrays& points, std::span<const float> field,
              std::vector<std::byte>& out) const;

 private:
  std::vector<PointField> fields_;
  std::string field_of_store_;  ///< name of its number; empty: none
  bool doubles_ = false;
};

}  // namespace isosplat::server
