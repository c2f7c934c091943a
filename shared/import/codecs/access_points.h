#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace isosplat::import {

/// A position between two blocks of deflated data. From here, decompression can start without the
/// preceding data (as in zlib's examples/zran.c).
struct AccessPoint {
  uint64_t output = 0;  ///< number of decompressed bytes before it
  uint64_t input = 0;   ///< offset in the file of the first whole byte after it
  int bits = 0;  ///< number of high bits of the preceding byte that belong to the data after it
  uint32_t trailer_bytes = 0;     ///< bytes of the container after the deflated data
  std::vector<std::byte> window;  ///< the up to 32 KiB of output before it
};

/// Access points in ascending order, about evenly spaced. If there are too many, every second one
/// is dropped and the distance doubles, so that they take at most 8 MiB.
class AccessPoints {
 public:
  static constexpr uint64_t kFirstDistance = uint64_t{1} << 20;
  static constexpr size_t kMaxPoints = 256;
  static constexpr uint64_t kWindowBytes = uint64_t{32} << 10;

  /// Whether a point after this many decompressed bytes is far enough from the last one.
  bool wants(uint64_t output) const {
    return output >= (points_.empty() ? 0 : points_.back().output) + distance_;
  }

  /// Requires wants(point.output).
  void add(AccessPoint point) {
    if (points_.size() == kMaxPoints) {
      size_t kept = 0;
      for (size_t i = 1; i < points_.size(); i += 2) std::swap(points_[kept++], points_[i]);
      points_.resize(kept);
      distance_ *= 2;
    }
    points_.push_back(std::move(point));
  }

  size_t count() const { return points_.size(); }

  /// The last point at or before this offset of the output; null if it is before all points.
  const AccessPoint* before(uint64_t output) const {
    const auto after = std::upper_bound(
        points_.begin(), points_.end(), output,
        [](uint64_t place, const AccessPoint& point) { return place < point.output; });
    return after == points_.begin() ? nullptr : &*(after - 1);
  }

  /// The maximum memory of the points for data of this size.
  static uint64_t max_bytes(uint64_t output) {
    return std::min<uint64_t>(kMaxPoints, output / kFirstDistance) * kWindowBytes;
  }

 private:
  std::vector<AccessPoint> points_;
  uint64_t distance_ = kFirstDistance;
};

}  // namespace isosplat::import
