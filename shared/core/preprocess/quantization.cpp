#include "shared/core/preprocess/quantization.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "shared/core/preprocess/value_lattice.h"

namespace isosplat {
namespace {

/// The largest quantized value of rounded voxels. 65535 is left for missing voxels.
constexpr uint32_t kMaxQuantized = 65534;

/// The least and greatest voxel of an integer type, as keys.
std::pair<uint64_t, uint64_t> keys_of(VoxelType type) {
  return with_voxel_type(type, []<class T>(T) {
    return std::pair(key_of(std::numeric_limits<T>::lowest()),
                     key_of(std::numeric_limits<T>::max()));
  });
}

/// The evenly spaced values that quantized values stand for: low + pitch · n for n from 0 to
/// `count` (at most 65535). In units of the file's voxels, before slope and intercept.
struct EvenValues {
  double low = 0, pitch = 1;
  uint64_t count = 0;
  double max_error = 0;
  bool is_integer = false;  ///< low_key and step are exact; low and pitch are the same as doubles
  uint64_t low_key = 0, step = 1;

  double high() const { return low + pitch * static_cast<double>(count); }
};

/// The rounding error of integers that become doubles; 0 up to 2^53.
double rounding_of_integers(const VoxelScan& scan) {
  const double most = std::max(std::abs(scan.min()), std::abs(scan.max()));
  return is_integer(scan.type()) && most > 0x1p53 ? most * 0x1p-52 : 0;
}

/// Values for integers that are stored without loss; nullopt if there would be more than 65536.
/// may_be_plain: if the step is 1, integers of up to 16 bits keep all values of their type.
std::optional<EvenValues> integer_values(const VoxelScan& scan, bool may_be_plain) {
  const VoxelType type = scan.type();
  if (!is_integer(type)) return std::nullopt;
  EvenValues values;
  values.is_integer = true;
  values.step = std::max<uint64_t>(scan.step(), 1);
  values.low_key = scan.low();
  values.count = (scan.high() - scan.low()) / values.step;
  if (may_be_plain && voxel_bytes(type) <= 2 && values.step == 1) {
    const auto [least, greatest] = keys_of(type);
    values.low_key = least;
    values.count = greatest - least;
  }
  if (values.count > 65535) return std::nullopt;
  values.low = voxel_of_key(type, values.low_key);
  values.pitch = static_cast<double>(values.step);
  values.max_error = rounding_of_integers(scan);
  return values;
}

/// The values of the lattice on which floating-point voxels lie; nullopt if there is none.
std::optional<EvenValues> lattice_values(const VoxelScan& scan) {
  if (is_integer(scan.type()) || scan.distinct().has_too_many()) return std::nullopt;
  const auto lattice = find_lattice(scan.distinct().sorted(), scan.type() == VoxelType::f32,
                                    scan.missing() > 0 ? kMaxQuantized : 65535);
  if (!lattice) return std::nullopt;
  EvenValues values;
  values.low = lattice->origin;
  values.pitch = lattice->step;
  values.count = lattice->steps;
  values.max_error = lattice->max_error;
  return values;
}

/// `count` steps over the range of the voxels.
EvenValues rounded_values(const VoxelScan& scan, uint32_t count) {
  EvenValues values;
  values.low_key = scan.low();
  values.low = scan.min();
  if (scan.max() > scan.min()) {
    values.count = count;
    values.pitch = std::max((scan.max() - scan.min()) / count, std::numeric_limits<double>::min());
    values.max_error = values.pitch * (0.5 + 1e-9) + rounding_of_integers(scan);
  }
  return values;
}

/// Reduces the number of values as far as no voxel is then further than max_error from its value:
/// each new value replaces an odd number of old ones, and is their middle.
void thin_out(EvenValues& values, double max_error) {
  const double each_side = std::floor((max_error - values.max_error) / values.pitch);
  if (!(each_side >= 1)) return;
  const auto reach = static_cast<uint64_t>(std::min(each_side, 65536.0));
  const uint64_t together = 2 * reach + 1;
  values.max_error += static_cast<double>(reach) * values.pitch;
  values.pitch *= static_cast<double>(together);
  values.step *= together;
  values.count = (values.count + reach) / together;
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

/// Chooses the values that the quantized values stand for. max_error: in the volume's values.
Result<EvenValues> choose_values(const VolumeHeader& header, const VoxelScan& scan,
                                 double max_error) {
  const double slope = std::abs(header.slope), voxel_error = max_error / slope;
  if (scan.is_empty()) {
    EvenValues none;
    none.is_integer = is_integer(scan.type());
    return none;
  }
  auto exact = integer_values(scan, voxel_error < 1);
  if (!exact) exact = lattice_values(scan);
  EvenValues values = exact ? *exact : rounded_values(scan, kMaxQuantized);
  if (!(max_error > 0)) return values;
  if (voxel_error < values.max_error) {
    return too_exact(max_error, values.max_error * slope, header, scan);
  }
  if (exact) {
    thin_out(values, voxel_error);
    return values;
  }
  const double count = std::ceil((scan.max() - scan.min()) * (1 + 1e-8) / (2 * voxel_error));
  return rounded_values(scan, static_cast<uint32_t>(std::clamp(count, 1.0, double{kMaxQuantized})));
}

/// Whether the voxels are their own quantized values, except for a constant.
bool is_plain(const EvenValues& values, VoxelType type) {
  return values.is_integer && values.step == 1 && voxel_bytes(type) <= 2;
}

/// The mapping from quantized values to the volume's values.
Result<ValueMapping> mapping_to(const EvenValues& values, const VolumeHeader& header,
                                const VoxelScan& scan) {
  const double slope = std::abs(header.slope);
  ValueMapping mapping;
  mapping.offset = header.value(header.slope < 0 ? values.high() : values.low);
  mapping.scale = slope * values.pitch;
  mapping.max_error = slope * values.max_error;
  mapping.has_missing = scan.missing() > 0;
  const bool is_narrow =
      is_plain(values, scan.type()) ? voxel_bytes(scan.type()) == 1 : values.count <= 255;
  mapping.bits = is_narrow && !mapping.has_missing ? 8 : 16;
  if (!std::isfinite(mapping.offset) || !std::isfinite(mapping.scale) || !(mapping.scale > 0) ||
      !std::isfinite(mapping.max_error)) {
    return fail(Status::malformed_volume,
                "expected a slope and an intercept with which values can be told apart, found " +
                    text_of(header.slope, 6) + " and " + text_of(header.intercept, 6) +
                    ": the header is damaged; export the volume again");
  }
  return mapping;
}

}  // namespace

Result<Quantization> choose_quantization(const VolumeHeader& header, const VoxelScan& scan,
                                         double max_error) {
  const auto values = choose_values(header, scan, max_error);
  if (!values) return tl::unexpected(values.error());
  const auto mapping = mapping_to(*values, header, scan);
  if (!mapping) return tl::unexpected(mapping.error());

  const bool is_reversed = header.slope < 0;
  Quantization quantization;
  quantization.type_ = scan.type();
  quantization.mapping_ = *mapping;
  quantization.max_ = static_cast<QuantizedValue>(values->count);
  quantization.is_plain_ = is_plain(*values, scan.type());
  quantization.is_quantized_ = !values->is_integer;
  quantization.is_reversed_ = is_reversed;
  quantization.step_ = values->step;
  quantization.pitch_ = values->pitch;
  quantization.first_key_ = !is_reversed         ? values->low_key
                            : values->is_integer ? values->low_key + values->step * values->count
                                                 : scan.high();
  quantization.first_ = is_reversed ? values->high() : values->low;
  if (!quantization.is_plain_ && voxel_bytes(scan.type()) <= 2) quantization.fill_table();
  return quantization;
}

void Quantization::fill_table() {
  with_voxel_type(type_, [&]<class T>(T) {
    if constexpr (sizeof(T) <= 2) {
      table_.resize(size_t{1} << 8 * sizeof(T));
      for (size_t i = 0; i < table_.size(); ++i) table_[i] = quantize(static_cast<T>(i));
    }
  });
}

template <class T>
QuantizedValue Quantization::quantize(T voxel) const {
  double position = 0;
  if constexpr (std::is_integral_v<T>) {
    const uint64_t key = key_of(voxel);
    if (!is_quantized_) {
      // Modulo 2^64. The greatest voxels may exceed the last value by less than half a step.
      const uint64_t distance = (is_reversed_ ? first_key_ - key : key - first_key_) + step_ / 2;
      return static_cast<QuantizedValue>(std::min<uint64_t>(distance / step_, max_));
    }
    position = static_cast<double>(is_reversed_ ? first_key_ - key : key - first_key_) / pitch_;
  } else {
    if (!has_value(voxel)) return kMissingVoxel;
    const auto wide = static_cast<double>(voxel);
    position = (is_reversed_ ? first_ - wide : wide - first_) / pitch_;
  }
  return static_cast<QuantizedValue>(
      std::clamp(std::floor(position + 0.5), 0.0, static_cast<double>(max_)));
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
