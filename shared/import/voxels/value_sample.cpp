#include "shared/import/voxels/value_sample.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {
namespace {

constexpr int32_t kSampledSlices = 64;
constexpr double kMinShare = 5e-4;  // of the sampled voxels
constexpr size_t kMaxLabels = 64;   // more different values than this are not labels
// A value with at least this share of the voxels at edges of slices is a background.
constexpr double kAroundShare = 0.25;
// A value with less than this share of the voxels at faces of the volume belongs to objects inside.
constexpr double kInsideShare = 0.01;
// A value fills compact regions if at least this share of its voxels has an equal neighbour.
constexpr double kJoinedShare = 0.5;

bool is_float(VoxelType type) {
  return type == VoxelType::f32 || type == VoxelType::f64;
}

/// Collects the different values of a volume, and determines whether they can be labels.
class Labels {
 public:
  void add(double value) {
    if (!can_be_ || (!values_.empty() && value == last_)) return;
    last_ = value;
    const auto at = std::lower_bound(values_.begin(), values_.end(), value);
    if (at != values_.end() && *at == value) return;
    values_.insert(at, value);
    can_be_ = values_.size() < kMaxLabels && value == std::floor(value);
  }
  bool are_all() const { return can_be_; }

 private:
  std::vector<double> values_;
  double last_ = 0;
  bool can_be_ = true;
};

/// Whether a voxel is at an edge of its slice, or at a face of the volume.
struct Place {
  bool at_edge = false, at_face = false;
};

/// `left`, `above`: the values of the neighbours; NaN if there are none.
void add(RangeEnd& end, double v, Place place, double left, double above) {
  if (v > end.value) {
    if (v < end.next) end.next = v;
    return;
  }
  if (v < end.value) {
    end = RangeEnd{v, end.value};
  }
  ++end.count;
  end.at_edge += place.at_edge;
  end.at_face += place.at_face;
  end.joined += left == v || above == v;
}

/// The values that programs use for "no value".
bool is_common_fill(double value) {
  for (const double known : {999.0, 9999.0, 99999.0, 999999.0, 32768.0}) {
    if (std::abs(value) == known) return true;
  }
  return std::abs(value) >= 1e20;  // 1e20, 9.96921e36 (netCDF), 3.4e38
}

/// For integers, also the ends of the types' ranges, and the values that CT scanners write outside
/// their circular field of view.
bool is_common_integer_fill(double value) {
  for (const double known :
       {-2000.0, -3024.0, -32767.0, 32767.0, 65535.0, -2147483648.0, 2147483647.0, 4294967295.0}) {
    if (value == known) return true;
  }
  return is_common_fill(value);
}

double share(uint64_t part, uint64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

/// `rest`: the range of all other values. `sign`: −1 for the upper end.
std::optional<OutlyingValue> outlying_at(const RangeEnd& end, double rest, double sign,
                                         const ValueSample& sample, VoxelType type) {
  const auto min_count = std::max(8.0, kMinShare * static_cast<double>(sample.count));
  if (!std::isfinite(end.next) || !(rest > 0) || static_cast<double>(end.count) < min_count) {
    return std::nullopt;
  }
  OutlyingValue found;
  found.value = sign * end.value;
  const double gap = end.next - end.value;
  const bool is_common =
      is_float(type) ? is_common_fill(found.value) : is_common_integer_fill(found.value);
  if (!(is_common ? gap > 0.1 * rest : gap > 10 * rest)) return std::nullopt;
  const bool is_compact = share(end.joined, end.count) >= kJoinedShare;
  if (share(end.at_edge, sample.edges) >= kAroundShare) {
    found.place = OutlyingValue::Place::around;
  } else if (is_compact) {
    found.place = OutlyingValue::Place::objects;
  }
  const bool is_inside = is_compact && share(end.at_face, sample.faces) < kInsideShare;
  // No object has a value of 1e20 or more.
  found.is_fill =
      is_float(type) && is_common && gap > rest && (!is_inside || std::abs(found.value) >= 1e20);
  return found;
}

}  // namespace

bool has_fill_value(const VolumeHeader& header, double voxel, const FillValue& fill) {
  const double value = header.value(voxel);
  const double tolerance = is_float(header.type)
                               ? 3e-7 * std::max(std::abs(fill.low), std::abs(fill.high))
                               : 1e-3 * std::abs(header.slope);
  return value >= fill.low - tolerance && value <= fill.high + tolerance;
}

bool can_have(const VolumeHeader& header, const FillValue& fill) {
  if (is_float(header.type)) return true;
  return with_voxel_type(header.type, [&]<class T>(T) {
    const double least = header.value(static_cast<double>(std::numeric_limits<T>::lowest()));
    const double most = header.value(static_cast<double>(std::numeric_limits<T>::max()));
    return fill.high >= std::min(least, most) && fill.low <= std::max(least, most);
  });
}

Result<ValueSample> sample_values(VolumeSource& source, const std::optional<FillValue>& fill) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const VolumeHeader& header = source.header();
  const Index3 n = header.grid.voxels;
  const auto width = static_cast<size_t>(n.x), height = static_cast<size_t>(n.y);
  const int32_t max_rows = rows_per_read(source, 8 << 20);
  std::vector<std::byte> rows;
  std::vector<double> above(width);
  ValueSample sample;
  Labels labels;
  const int32_t slices = std::min(n.z, kSampledSlices);
  for (int32_t i = 0; i < slices; ++i) {
    const auto z = static_cast<int32_t>(int64_t{i} * (n.z - 1) / std::max(slices - 1, 1));
    std::fill(above.begin(), above.end(), kNone);
    for (int32_t first = 0; first < n.y; first += max_rows) {
      const SliceRows part{z, 1, first, std::min(max_rows, n.y - first)};
      rows.resize(part.voxels(n.x) * voxel_bytes(header.type));
      if (auto read = source.read_rows(part, rows); !read) return tl::unexpected(read.error());
      with_voxel_type(header.type, [&]<class T>(T) {
        const std::byte* from = rows.data();
        const auto begin = static_cast<size_t>(first), end = begin + static_cast<size_t>(part.rows);
        for (size_t y = begin; y < end; ++y) {
          double left = kNone;
          for (size_t x = 0; x < width; ++x, from += sizeof(T)) {
            T voxel;
            std::memcpy(&voxel, from, sizeof(T));
            const double v = header.value(static_cast<double>(voxel));
            Place place;
            place.at_edge = x == 0 || y == 0 || x + 1 == width || y + 1 == height;
            place.at_face = place.at_edge || z == 0 || z + 1 == n.z;
            sample.edges += place.at_edge;
            sample.faces += place.at_face;
            if (fill && has_fill_value(header, static_cast<double>(voxel), *fill)) {
              ++sample.filled;
            } else if (std::isfinite(v)) {
              add(sample.low, v, place, left, above[x]);
              add(sample.high, -v, place, -left, -above[x]);
              labels.add(v);
              ++sample.count;
            }
            left = above[x] = v;
          }
        }
      });
    }
  }
  sample.is_whole = slices == n.z;
  sample.is_label_map = sample.count > 0 && labels.are_all();
  return sample;
}

std::optional<OutlyingValue> outlying_value(const ValueSample& sample, VoxelType type) {
  const RangeEnd& low = sample.low;
  const RangeEnd& high = sample.high;
  if (const auto found = outlying_at(low, -high.value - low.next, 1, sample, type)) return found;
  return outlying_at(high, -high.next - low.value, -1, sample, type);
}

}  // namespace isosplat::import
