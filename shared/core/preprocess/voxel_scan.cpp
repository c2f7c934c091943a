#include "shared/core/preprocess/voxel_scan.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <type_traits>

namespace isosplat {
namespace {

bool is_signed(VoxelType type) {
  return with_voxel_type(type, []<class T>(T) { return std::is_signed_v<T>; });
}

/// The message of a scan. Its distinct numbers follow.
struct ScanMessage {
  uint32_t type = 0, is_empty = 0, has_too_many = 0, distinct = 0;
  uint64_t missing = 0, low = 0, high = 0, step = 0;
  double min = 0, max = 0;
};

uint64_t distance(uint64_t a, uint64_t b) {
  return std::max(a, b) - std::min(a, b);
}

}  // namespace

double voxel_of_key(VoxelType type, uint64_t key) {
  return is_signed(type) ? static_cast<double>(static_cast<int64_t>(key ^ uint64_t{1} << 63))
                         : static_cast<double>(key);
}

double VoxelScan::min() const {
  return is_integer(type_) ? voxel_of_key(type_, low_) : min_;
}

double VoxelScan::max() const {
  return is_integer(type_) ? voxel_of_key(type_, high_) : max_;
}

template <class T>
void VoxelScan::add_integers(const T* voxels, size_t count) {
  T low = voxels[0], high = voxels[0];
  for (size_t i = 0; i < count; ++i) {
    low = std::min(low, voxels[i]);
    high = std::max(high, voxels[i]);
  }
  const uint64_t low_key = key_of(low), high_key = key_of(high);
  if (is_empty_) low_ = high_ = low_key;
  uint64_t step = std::gcd(step_, distance(low_, low_key));
  // The difference of two voxels equals that of their keys, and fits the type's unsigned variant.
  using Unsigned = std::make_unsigned_t<T>;
  using Word = std::conditional_t<sizeof(T) == 8, uint64_t, uint32_t>;
  for (size_t i = 0; i < count && step != 1; ++i) {
    const auto difference = static_cast<Word>(
        static_cast<Unsigned>(static_cast<Unsigned>(voxels[i]) - static_cast<Unsigned>(low)));
    if (step == 0 || difference % static_cast<Word>(step) != 0) {
      step = std::gcd(step, uint64_t{difference});
    }
  }
  step_ = step;
  low_ = std::min(low_, low_key);
  high_ = std::max(high_, high_key);
  is_empty_ = false;
}

template <class T>
void VoxelScan::add_floats(const T* voxels, size_t count) {
  // Infinities as neutral elements avoid branches. The loop must not take longer than reading the
  // voxels.
  T low = std::numeric_limits<T>::infinity(), high = -low;
  uint64_t with_value = 0;
  for (size_t i = 0; i < count; ++i) {
    const bool has = has_value(voxels[i]);
    with_value += has;
    low = has && voxels[i] < low ? voxels[i] : low;
    high = has && voxels[i] > high ? voxels[i] : high;
  }
  missing_ += count - with_value;
  if (with_value == 0) return;
  min_ = is_empty_ ? low : std::min<double>(min_, low);
  max_ = is_empty_ ? high : std::max<double>(max_, high);
  is_empty_ = false;
  for (size_t i = 0; i < count && !distinct_.has_too_many(); ++i) {
    if (has_value(voxels[i])) distinct_.add(voxels[i]);
  }
}

void VoxelScan::add(std::span<const std::byte> voxels) {
  if (voxels.empty()) return;
  with_voxel_type(type_, [&]<class T>(T) {
    const auto* typed = reinterpret_cast<const T*>(voxels.data());
    if constexpr (std::is_integral_v<T>) {
      add_integers(typed, voxels.size() / sizeof(T));
    } else {
      add_floats(typed, voxels.size() / sizeof(T));
    }
  });
}

void VoxelScan::add(const VoxelScan& other) {
  missing_ += other.missing_;
  if (other.is_empty_) return;
  if (is_empty_) {
    low_ = other.low_, high_ = other.high_, min_ = other.min_, max_ = other.max_;
  }
  step_ = std::gcd(std::gcd(step_, other.step_), distance(low_, other.low_));
  low_ = std::min(low_, other.low_), high_ = std::max(high_, other.high_);
  min_ = std::min(min_, other.min_), max_ = std::max(max_, other.max_);
  is_empty_ = false;
  distinct_.add(other.distinct_);
}

std::vector<std::byte> VoxelScan::bytes() const {
  const std::vector<double> distinct = distinct_.sorted();
  const ScanMessage head{static_cast<uint32_t>(type_),
                         is_empty_,
                         distinct_.has_too_many(),
                         static_cast<uint32_t>(distinct.size()),
                         missing_,
                         low_,
                         high_,
                         step_,
                         min_,
                         max_};
  std::vector<std::byte> message(sizeof head + distinct.size() * sizeof(double));
  std::memcpy(message.data(), &head, sizeof head);
  if (!distinct.empty()) {
    std::memcpy(message.data() + sizeof head, distinct.data(), distinct.size() * sizeof(double));
  }
  return message;
}

Result<void> VoxelScan::add_message(std::span<const std::byte> bytes) {
  ScanMessage head;
  const bool has_head = bytes.size() >= sizeof head;
  if (has_head) std::memcpy(&head, bytes.data(), sizeof head);
  if (!has_head || head.type != static_cast<uint32_t>(type_) ||
      head.distinct > DistinctValues::kMax ||
      bytes.size() != sizeof head + head.distinct * sizeof(double)) {
    return fail(Status::invalid_argument,
                "expected a scan of voxels of this volume's type, found another message");
  }
  VoxelScan other(type_);
  other.is_empty_ = head.is_empty != 0;
  other.missing_ = head.missing;
  other.low_ = head.low, other.high_ = head.high, other.step_ = head.step;
  other.min_ = head.min, other.max_ = head.max;
  for (size_t i = 0; i < head.distinct; ++i) {
    double value = 0;
    std::memcpy(&value, bytes.data() + sizeof head + i * sizeof value, sizeof value);
    other.distinct_.add(value);
  }
  if (head.has_too_many) other.distinct_.give_up();
  add(other);
  return {};
}

}  // namespace isosplat
