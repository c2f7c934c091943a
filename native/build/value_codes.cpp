#include "native/build/value_codes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace isosplat {
namespace {

/// Calls f with a value of the C++ type that a voxel type stands for.
template <class F>
auto with_type(VoxelType type, F f) {
  switch (type) {
    case VoxelType::u8:
      return f(uint8_t{});
    case VoxelType::i8:
      return f(int8_t{});
    case VoxelType::u16:
      return f(uint16_t{});
    case VoxelType::i16:
      return f(int16_t{});
    case VoxelType::u32:
      return f(uint32_t{});
    case VoxelType::i32:
      return f(int32_t{});
    case VoxelType::f32:
      return f(float{});
    case VoxelType::f64:
      break;
  }
  return f(double{});
}

/// Whether a voxel has a value. Doubles beyond this could not be told apart by their distance,
/// which may overflow; they are placeholders in all data that has them.
template <class T>
bool has_value(T value) {
  constexpr double kMost = 1e300;
  if constexpr (sizeof(T) == 8) return std::abs(value) <= kMost;
  return std::abs(value) <= std::numeric_limits<T>::max();
}

template <class T>
ValueRange range_of_typed(const T* values, size_t count) {
  ValueRange range;
  if (count == 0) return range;
  if constexpr (std::is_floating_point_v<T>) {
    // Infinities as neutral elements keep the loop free of branches: it must not cost more than
    // reading the voxels does.
    T low = std::numeric_limits<T>::infinity(), high = -low;
    uint64_t finite = 0;
    for (size_t i = 0; i < count; ++i) {
      const bool is_finite = has_value(values[i]);
      finite += is_finite;
      low = is_finite && values[i] < low ? values[i] : low;
      high = is_finite && values[i] > high ? values[i] : high;
    }
    range.missing = count - finite;
    range.is_empty = finite == 0;
    if (finite > 0) range.min = low, range.max = high;
  } else {
    T low = values[0], high = values[0];
    for (size_t i = 0; i < count; ++i) {
      low = std::min(low, values[i]);
      high = std::max(high, values[i]);
    }
    range.min = low, range.max = high;
    range.is_empty = false;
  }
  return range;
}

template <class T>
Code quantise(const ValueMapping& mapping, T value) {
  if constexpr (std::is_floating_point_v<T>) {
    if (!has_value(value)) return kMissingCode;
  }
  const double code =
      std::floor((static_cast<double>(value) - mapping.offset) / mapping.scale + 0.5);
  return static_cast<Code>(std::clamp(code, 0.0, 65534.0));
}

template <class T>
void encode_typed(const ValueMapping& mapping, const std::byte* from, size_t count, void* to) {
  if constexpr (sizeof(T) == 1) {
    const auto flip = static_cast<uint8_t>(std::is_signed_v<T> ? 0x80 : 0);
    const auto* voxels = reinterpret_cast<const uint8_t*>(from);
    auto* codes = static_cast<uint8_t*>(to);
    for (size_t i = 0; i < count; ++i) codes[i] = static_cast<uint8_t>(voxels[i] ^ flip);
  } else if constexpr (sizeof(T) == 2) {
    const auto flip = static_cast<uint16_t>(std::is_signed_v<T> ? 0x8000 : 0);
    const auto* voxels = reinterpret_cast<const uint16_t*>(from);
    auto* codes = static_cast<uint16_t*>(to);
    for (size_t i = 0; i < count; ++i) codes[i] = static_cast<uint16_t>(voxels[i] ^ flip);
  } else {
    const auto* voxels = reinterpret_cast<const T*>(from);
    auto* codes = static_cast<uint16_t*>(to);
    if (std::is_integral_v<T> && mapping.max_error == 0) {
      const auto least = static_cast<T>(mapping.offset);
      for (size_t i = 0; i < count; ++i) {
        codes[i] =
            static_cast<uint16_t>(static_cast<uint32_t>(voxels[i]) - static_cast<uint32_t>(least));
      }
    } else {
      for (size_t i = 0; i < count; ++i) codes[i] = quantise(mapping, voxels[i]);
    }
  }
}

}  // namespace

void ValueRange::include(const ValueRange& other) {
  missing += other.missing;
  if (other.is_empty) return;
  min = is_empty ? other.min : std::min(min, other.min);
  max = is_empty ? other.max : std::max(max, other.max);
  is_empty = false;
}

ValueRange range_of(VoxelType type, std::span<const std::byte> voxels) {
  return with_type(type, [&](auto zero) {
    using T = decltype(zero);
    return range_of_typed(reinterpret_cast<const T*>(voxels.data()), voxels.size() / sizeof(T));
  });
}

ValueMapping choose_mapping(VoxelType type, const ValueRange& range) {
  ValueMapping mapping;
  mapping.bits = voxel_bytes(type) == 1 ? 8 : 16;
  if (type == VoxelType::i8) mapping.offset = -128;
  if (type == VoxelType::i16) mapping.offset = -32768;
  if (voxel_bytes(type) <= 2 || range.is_empty) {
    mapping.has_missing = range.missing > 0;
    return mapping;
  }
  mapping.offset = range.min;
  mapping.has_missing = range.missing > 0;
  const bool is_integer = type == VoxelType::u32 || type == VoxelType::i32;
  if (is_integer && range.max - range.min <= 65535) return mapping;
  if (range.max > range.min) {
    mapping.scale = std::max((range.max - range.min) / 65534, std::numeric_limits<double>::min());
    mapping.max_error = mapping.scale * (0.5 + 1e-9);
  }
  return mapping;
}

void encode_values(VoxelType type, const ValueMapping& mapping, std::span<const std::byte> voxels,
                   void* codes) {
  with_type(type, [&](auto zero) {
    using T = decltype(zero);
    encode_typed<T>(mapping, voxels.data(), voxels.size() / sizeof(T), codes);
  });
}

}  // namespace isosplat
