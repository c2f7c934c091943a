#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/points/chunk_samples.h"

namespace isosplat::server {

enum class PointField : uint8_t { positions, normals, values };

/// A record per point with some fields, little-endian and without padding: an array of NumPy.
/// Positions are three numbers in double or single precision, normals three and values one in
/// single precision.
class PointRecords {
 public:
  /// "positions,normals,values": some of them, in any order, each once. Errors: invalid_argument.
  static Result<PointRecords> parse(std::string_view fields, bool double_positions);

  bool has(PointField field) const;

  /// Size of a record in bytes.
  size_t bytes() const;

  /// The type as NumPy writes it: a list of fields, also if it is only one.
  std::string dtype() const;

  /// The header of a .npy file (version 1.0) for `count` records, before the records. One field: an
  /// array of the shape (count, 3), or (count) for values; several: a structured array.
  std::string npy_header(uint64_t count) const;

  /// Appends a record for each point. `points` must have the arrays of the fields.
  void append(const PointArrays& points, std::vector<std::byte>& out) const;

 private:
  std::vector<PointField> fields_;
  bool doubles_ = false;
};

}  // namespace isosplat::server
