#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/axes/array_attributes.h"

namespace isosplat::import::netcdf {

struct Dimension {
  std::string name;
  uint64_t size = 0;
  bool is_record = false;  ///< each record of the file has one element along it
};

/// The text or the numbers of an attribute; neither if there are more than are useful here.
struct Attribute {
  std::string name;
  std::string text = {};
  std::vector<double> numbers = {};
  std::optional<VoxelType> type = {};  ///< of the numbers
};

/// An array, as the header states it.
struct Variable : ArrayAttributes {
  std::optional<std::vector<double>> numbers(std::string_view name) const override;
  std::optional<VoxelType> number_type(std::string_view name) const override;
  std::string text(std::string_view name) const override;

  const Attribute* find(std::string_view name) const;

  std::string name;
  std::vector<size_t> dimensions;  ///< indices, the slowest first
  std::vector<Attribute> attributes;
  std::optional<VoxelType> type;  ///< nothing: of characters
  uint64_t begin = 0;             ///< offset of the first element in the file
};

/// The header of a file in netCDF's classic format (CDF-1), with 64-bit offsets (CDF-2), or with
/// 64-bit data (CDF-5).
struct Header {
  std::vector<Dimension> dimensions;
  std::vector<Variable> variables;
  uint64_t record_bytes = 0;  ///< from a record to the next one

  const Variable* find(std::string_view name) const;
  /// Sizes along the axes of a variable.
  std::vector<uint64_t> sizes(const Variable& variable) const;
  bool has_records(const Variable& variable) const;
};

/// Source: NetCDF Users Guide, appendix B (file format specifications). Errors: malformed_volume,
/// truncated, io_error; unsupported_format for a header above 64 MiB.
Result<Header> read_header(const std::filesystem::path& path);

}  // namespace isosplat::import::netcdf
