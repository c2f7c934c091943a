#include "shared/import/zarr/elements.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

#include "shared/import/zarr/metadata.h"

namespace isosplat::import::zarr {
namespace {

/// The bytes of an unsigned number in an element's byte order.
std::vector<std::byte> bytes_of(uint64_t number, const StoredVoxels& stored) {
  std::vector<std::byte> bytes(stored_bytes(stored));
  for (size_t i = 0; i < bytes.size(); ++i) {
    const size_t to = stored.big_endian ? bytes.size() - 1 - i : i;
    bytes[to] = static_cast<std::byte>(number >> 8 * i);
  }
  return bytes;
}

/// The bits of a number as IEEE 754 binary16; only those numbers that fill values usually are.
uint64_t half_bits(double value) {
  if (std::isnan(value)) return 0x7e00;
  if (std::isinf(value)) return value > 0 ? 0x7c00 : 0xfc00;
  int exponent = 0;
  const double fraction = std::frexp(std::abs(value), &exponent);
  const uint64_t sign = std::signbit(value) ? 0x8000 : 0;
  if (value == 0 || exponent < -13) return sign;
  if (exponent > 16) return sign | 0x7c00;
  return sign | (static_cast<uint64_t>(exponent + 14) << 10) |
         static_cast<uint64_t>((fraction * 2 - 1) * 1024);
}

}  // namespace

Result<StoredVoxels> type_of(const std::string& name, const std::filesystem::path& folder) {
  struct Known {
    std::string_view name, letters;
    VoxelType type;
    bool is_half = false;
  };
  constexpr Known kTypes[] = {
      {"uint8", "u1", VoxelType::u8},          {"int8", "i1", VoxelType::i8},
      {"uint16", "u2", VoxelType::u16},        {"int16", "i2", VoxelType::i16},
      {"uint32", "u4", VoxelType::u32},        {"int32", "i4", VoxelType::i32},
      {"uint64", "u8", VoxelType::u64},        {"int64", "i8", VoxelType::i64},
      {"float32", "f4", VoxelType::f32},       {"float64", "f8", VoxelType::f64},
      {"float16", "f2", VoxelType::f32, true}, {"bool", "b1", VoxelType::u8},
  };
  const bool has_order = name.size() == 3 && std::string_view("<>|=").find(name[0]) != name.npos;
  for (const Known& known : kTypes) {
    if (name != known.name && (!has_order || name.substr(1) != known.letters)) continue;
    StoredVoxels stored;
    stored.type = known.type;
    stored.is_half = known.is_half;
    stored.big_endian = has_order && name[0] == '>';
    return stored;
  }
  return fail(
      Status::unsupported_type,
      fmt::format("{}: expected integers, or floating-point numbers of 16 to 64 bits, found "
                  "the type {}: convert the array",
                  folder.string(), text_of(name)));
}

Result<std::vector<std::byte>> fill_of(const Json& fill, const StoredVoxels& stored,
                                       const std::filesystem::path& folder) {
  if (fill.is_null() || fill == 0) return std::vector<std::byte>{};
  if (fill.is_boolean()) return bytes_of(fill.get<bool>() ? 1 : 0, stored);
  const bool is_float = stored.type == VoxelType::f32 || stored.type == VoxelType::f64;
  if (!is_float && fill.is_number_integer()) {
    return bytes_of(fill.is_number_unsigned() ? fill.get<uint64_t>()
                                              : static_cast<uint64_t>(fill.get<int64_t>()),
                    stored);
  }
  double value = std::numeric_limits<double>::quiet_NaN();
  bool is_value = fill.is_number();
  if (is_value) value = fill.get<double>();
  if (fill.is_string()) {
    const auto text = fill.get<std::string>();
    if (text.starts_with("0x")) {
      uint64_t bits = 0;
      const auto [end, error] =
          std::from_chars(text.data() + 2, text.data() + text.size(), bits, 16);
      if (error == std::errc() && end == text.data() + text.size()) return bytes_of(bits, stored);
    }
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    is_value = text == "NaN" || text == "Infinity" || text == "-Infinity";
    if (text == "Infinity") value = kInfinity;
    if (text == "-Infinity") value = -kInfinity;
  }
  if (!is_value || !is_float) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected a fill value of the array's type, found {}",
                            folder.string(), text_of(fill)));
  }
  if (stored.is_half) return bytes_of(half_bits(value), stored);
  if (stored.type == VoxelType::f64) return bytes_of(std::bit_cast<uint64_t>(value), stored);
  return bytes_of(std::bit_cast<uint32_t>(static_cast<float>(value)), stored);
}

}  // namespace isosplat::import::zarr
