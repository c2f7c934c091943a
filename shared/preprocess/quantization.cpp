#include "shared/preprocess/quantization.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "shared/preprocess/value_lattice.h"

namespace isosplat {
namespace {

/// The largest quantized value of voxels that are rounded, whether or not some are missing.
constexpr uint32_t kMaxQuantized = 65534;

/// The least and greatest voxel of an integer type, as keys.
std::pair<uint64_t, uint64_t> keys_of(VoxelType type) {
  return with_voxel_type(type, []<class T>(T) {
    return std::pair(key_of(std::numeric_limits<T>::lowest()),
                     key_of(std::numeric_limits<T>::max()));
  });
}

/// What stands between a voxel and its quantized value, before slope and intercept: places low +
/// pitch · n for n from 0 to `count`. All in units of voxels.
struct Places {
  double low = 0, pitch = 1;
  uint64_t count = 0;
  double max_error = 0;
  bool is_integer = false;  ///< the following hold, and low and pitch follow from them
  uint64_t low_key = 0, step = 1;
};

/// Beyond 2^53 a double has no room for each integer.
double rounding_of_integers(const VoxelScan& scan) {
  const double most = std::max(std::abs(scan.min()), std::abs(scan.max()));
  return is_integer(scan.type()) && most > 0x1p53 ? most * 0x1p-52 : 0;
}

/// Places for integers that are kept; nothing where there would be too many. `may_be_plain`: all
/// that a narrow type has, where no coarser step is found.
std::optional<Places> integer_places(const VoxelScan& scan, bool may_be_plain) {
  const VoxelType type = scan.type();
  if (!is_integer(type)) return std::nullopt;
  Places places;
  places.is_integer = true;
  places.step = std::max<uint64_t>(scan.step(), 1);
  places.low_key = scan.low();
  places.count = (scan.high() - scan.low()) / places.step;
  if (may_be_plain && voxel_bytes(type) <= 2 && places.step == 1) {
    const auto [least, greatest] = keys_of(type);
    places.low_key = least;
    places.count = greatest - least;
  }
  if (places.count > 65535) return std::nullopt;
  places.low = voxel_of_key(type, places.low_key);
  places.pitch = static_cast<double>(places.step);
  places.max_error = rounding_of_integers(scan);
  return places;
}

std::optional<Places> lattice_places(const VoxelScan& scan) {
  if (is_integer(scan.type()) || scan.distinct().has_too_many()) return std::nullopt;
  const auto lattice = find_lattice(scan.distinct().sorted(), scan.type() == VoxelType::f32,
                                    scan.missing() > 0 ? kMaxQuantized : 65535);
  if (!lattice) return std::nullopt;
  Places places;
  places.low = lattice->origin;
  places.pitch = lattice->step;
  places.count = lattice->steps;
  places.max_error = lattice->max_error;
  return places;
}

/// `count` even steps over the range.
Places quantized_places(const VoxelScan& scan, uint32_t count) {
  Places places;
  places.low_key = scan.low();
  places.low = scan.min();
  if (scan.max() > scan.min()) {
    places.count = count;
    places.pitch = std::max((scan.max() - scan.min()) / count, std::numeric_limits<double>::min());
    places.max_error = places.pitch * (0.5 + 1e-9) + rounding_of_integers(scan);
  }
  return places;
}

/// Fewer places, where that leaves no voxel further than `max_error` from its place: each stands
/// for an odd number of those before, of which it is the middle.
void thin_out(Places& places, double max_error) {
  const double each_side = std::floor((max_error - places.max_error) / places.pitch);
  if (!(each_side >= 1)) return;
  const auto reach = static_cast<uint64_t>(std::min(each_side, 65536.0));
  const uint64_t together = 2 * reach + 1;
  places.max_error += static_cast<double>(reach) * places.pitch;
  places.pitch *= static_cast<double>(together);
  places.step *= together;
  places.count = (places.count + reach) / together;
}

std::string text_of(double value, int digits) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return text.data();
}

tl::unexpected<Error> too_exact(double max_error, double least, const VolumeHeader& header,
                                const VoxelScan& scan) {
  const auto [low, high] = std::minmax({header.value(scan.min()), header.value(scan.max())});
  return fail(Status::invalid_argument,
              "--max-error " + text_of(max_error, 6) + ": expected at least " + text_of(least, 3) +
                  ", which is what 16 bits can do for values from " + text_of(low, 6) + " to " +
                  text_of(high, 6) + ": give " + text_of(least * 1.01, 3) + ", or leave it away");
}

}  // namespace

Result<Quantization> choose_quantization(const VolumeHeader& header, const VoxelScan& scan,
                                         double max_error) {
  const double slope = std::abs(header.slope);
  const double voxel_error = max_error / slope;
  Quantization quantization;
  quantization.type_ = scan.type();
  Places places;
  if (scan.is_empty()) {
    places.is_integer = is_integer(scan.type());
  } else {
    auto kept = integer_places(scan, voxel_error < 1);
    if (!kept) kept = lattice_places(scan);
    places = kept ? *kept : quantized_places(scan, kMaxQuantized);
    if (max_error > 0 && voxel_error < places.max_error) {
      return too_exact(max_error, places.max_error * slope, header, scan);
    }
    if (max_error > 0 && kept) {
      thin_out(places, voxel_error);
    } else if (max_error > 0) {
      const double count = std::ceil((scan.max() - scan.min()) * (1 + 1e-8) / (2 * voxel_error));
      places = quantized_places(
          scan, static_cast<uint32_t>(std::clamp(count, 1.0, double{kMaxQuantized})));
    }
  }
  quantization.max_ = static_cast<QuantizedValue>(places.count);  // at most 65535 by now

  ValueMapping& mapping = quantization.mapping_;
  const bool is_reversed = header.slope < 0;
  const double high = places.low + places.pitch * static_cast<double>(places.count);
  mapping.offset = header.value(is_reversed ? high : places.low);
  mapping.scale = slope * places.pitch;
  mapping.max_error = slope * places.max_error;
  mapping.has_missing = scan.missing() > 0;
  const bool is_plain = places.is_integer && places.step == 1 && voxel_bytes(scan.type()) <= 2;
  const bool is_narrow = is_plain ? voxel_bytes(scan.type()) == 1 : places.count <= 255;
  mapping.bits = is_narrow && !mapping.has_missing ? 8 : 16;
  if (!std::isfinite(mapping.offset) || !std::isfinite(mapping.scale) || !(mapping.scale > 0) ||
      !std::isfinite(mapping.max_error)) {
    return fail(Status::malformed_volume,
                "expected a slope and an intercept with which values can be told apart, found " +
                    text_of(header.slope, 6) + " and " + text_of(header.intercept, 6) +
                    ": the header is damaged; export the volume again");
  }

  quantization.is_plain_ = is_plain;
  quantization.is_quantized_ = !places.is_integer;
  quantization.is_reversed_ = is_reversed;
  quantization.step_ = places.step;
  quantization.pitch_ = places.pitch;
  quantization.first_key_ = !is_reversed        ? places.low_key
                            : places.is_integer ? places.low_key + places.step * places.count
                                                : scan.high();
  quantization.first_ = is_reversed ? high : places.low;
  if (!is_plain && voxel_bytes(scan.type()) <= 2) {
    with_voxel_type(scan.type(), [&]<class T>(T) {
      if constexpr (sizeof(T) <= 2) {
        quantization.table_.resize(size_t{1} << 8 * sizeof(T));
        for (size_t i = 0; i < quantization.table_.size(); ++i) {
          quantization.table_[i] = quantization.quantize(static_cast<T>(i));
        }
      }
    });
  }
  return quantization;
}

template <class T>
QuantizedValue Quantization::quantize(T voxel) const {
  double place = 0;
  if constexpr (std::is_integral_v<T>) {
    const uint64_t key = key_of(voxel);
    if (!is_quantized_) {
      // Modulo 2^64: the greatest voxels may lie beyond the last place by less than half a step.
      const uint64_t distance = (is_reversed_ ? first_key_ - key : key - first_key_) + step_ / 2;
      return static_cast<QuantizedValue>(std::min<uint64_t>(distance / step_, max_));
    }
    place = static_cast<double>(is_reversed_ ? first_key_ - key : key - first_key_) / pitch_;
  } else {
    if (!has_value(voxel)) return kMissingVoxel;
    const auto wide = static_cast<double>(voxel);
    place = (is_reversed_ ? first_ - wide : wide - first_) / pitch_;
  }
  return static_cast<QuantizedValue>(
      std::clamp(std::floor(place + 0.5), 0.0, static_cast<double>(max_)));
}

template <class T>
void Quantization::encode_typed(const T* voxels, size_t count, void* to) const {
  if constexpr (sizeof(T) <= 2) {
    using Word = std::make_unsigned_t<T>;
    const auto* words = reinterpret_cast<const Word*>(voxels);
    if (is_plain_) {
      // Moves signed numbers up by half the range; the complement of the result is its reverse.
      const auto sign = static_cast<Word>(std::is_signed_v<T> ? 1u << (8 * sizeof(T) - 1) : 0u);
      const auto flip = static_cast<Word>(is_reversed_ ? ~sign : sign);
      auto* quantized_values = static_cast<Word*>(to);
      for (size_t i = 0; i < count; ++i) quantized_values[i] = static_cast<Word>(words[i] ^ flip);
    } else if (mapping_.bits == 8) {
      auto* quantized_values = static_cast<uint8_t*>(to);
      for (size_t i = 0; i < count; ++i)
        quantized_values[i] = static_cast<uint8_t>(table_[words[i]]);
    } else {
      auto* quantized_values = static_cast<QuantizedValue*>(to);
      for (size_t i = 0; i < count; ++i) quantized_values[i] = table_[words[i]];
    }
  } else if (mapping_.bits == 8) {
    auto* quantized_values = static_cast<uint8_t*>(to);
    for (size_t i = 0; i < count; ++i)
      quantized_values[i] = static_cast<uint8_t>(quantize(voxels[i]));
  } else {
    auto* quantized_values = static_cast<QuantizedValue*>(to);
    for (size_t i = 0; i < count; ++i) quantized_values[i] = quantize(voxels[i]);
  }
}

void Quantization::encode(std::span<const std::byte> voxels, void* quantized_values) const {
  with_voxel_type(type_, [&]<class T>(T) {
    encode_typed(reinterpret_cast<const T*>(voxels.data()), voxels.size() / sizeof(T),
                 quantized_values);
  });
}

}  // namespace isosplat
