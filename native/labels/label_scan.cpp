#include "native/labels/label_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "shared/core/preprocess/voxel_scan.h"

namespace isosplat {
namespace {

constexpr double kMaxValue = 9007199254740992.0;  // 2^53: larger integers are not all doubles

/// Slices are read in groups of at most this many bytes, or one by one.
constexpr size_t kReadBytes = size_t{8} << 20;

class LabelScan {
 public:
  LabelScan(VolumeSource& source, LabelRows& rows, const LabelScanOptions& options)
      : source_(source), header_(source.header()), rows_(rows), options_(options) {}

  Result<std::vector<FoundLabel>> run() {
    const Index3 n = header_.grid.voxels;
    const size_t slice =
        static_cast<size_t>(n.x) * static_cast<size_t>(n.y) * voxel_bytes(header_.type);
    const auto most =
        static_cast<int32_t>(std::clamp<size_t>(kReadBytes / slice, 1, static_cast<size_t>(n.z)));
    std::vector<std::byte> bytes(slice * static_cast<size_t>(most));
    for (int32_t z = 0; z < n.z; z += most) {
      const int32_t count = std::min(most, n.z - z);
      const auto part = std::span(bytes).first(slice * static_cast<size_t>(count));
      if (auto read = source_.read_slices(z, count, part); !read) {
        return tl::unexpected(read.error());
      }
      const auto added =
          with_voxel_type(header_.type, [&]<class T>(T) { return add<T>(part.data(), z, count); });
      if (!added) return tl::unexpected(added.error());
      if (options_.progress) options_.progress(static_cast<double>(z + count) / n.z);
    }
    std::sort(labels_.begin(), labels_.end(),
              [](const FoundLabel& a, const FoundLabel& b) { return a.value < b.value; });
    return std::move(labels_);
  }

 private:
  std::string name() const { return header_.name; }

  template <class T>
  Result<void> add(const std::byte* from, int32_t first, int32_t count) {
    const Index3 n = header_.grid.voxels;
    std::vector<T> voxels(static_cast<size_t>(n.x));
    for (int32_t z = first; z < first + count; ++z) {
      for (int32_t y = 0; y < n.y; ++y, from += voxels.size() * sizeof(T)) {
        std::memcpy(voxels.data(), from, voxels.size() * sizeof(T));
        uint16_t* const to = rows_.row(y, z);
        for (int32_t begin = 0, end = 0; begin < n.x; begin = end) {
          const T voxel = voxels[static_cast<size_t>(begin)];
          end = begin + 1;
          while (end < n.x && voxels[static_cast<size_t>(end)] == voxel) ++end;
          const auto index = index_of(voxel);
          if (!index) return tl::unexpected(index.error());
          if (*index == 0) continue;
          std::fill(to + begin, to + end, *index);
          add_run(labels_[*index - 1u], {begin, y, z}, end - 1);
        }
      }
    }
    return {};
  }

  static void add_run(FoundLabel& label, Index3 at, int32_t last) {
    label.voxels += static_cast<uint64_t>(last - at.x + 1);
    label.low = {std::min(label.low.x, at.x), std::min(label.low.y, at.y),
                 std::min(label.low.z, at.z)};
    label.high = {std::max(label.high.x, last), std::max(label.high.y, at.y),
                  std::max(label.high.z, at.z)};
  }

  template <class T>
  Result<uint16_t> index_of(T voxel) {
    if constexpr (std::is_floating_point_v<T>) {
      if (!has_value(voxel)) return uint16_t{0};
    }
    const double found = header_.value(static_cast<double>(voxel));
    if (is_known_ && found == last_value_) return last_index_;
    if (std::abs(found) > kMaxValue || found != std::floor(found)) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected integers up to 2^53 as labels, found {}: build a store "
                              "of this volume without --labels",
                              name(), found));
    }
    const auto value = static_cast<int64_t>(found);
    uint16_t index = 0;
    if (value != options_.background && value == options_.only.value_or(value)) {
      const auto [at, is_new] = indices_.try_emplace(value, uint16_t{0});
      if (is_new) {
        if (labels_.size() == options_.max_labels) {
          return fail(Status::malformed_volume,
                      fmt::format("{}: expected at most {} labels, which is the limit of a scene's "
                                  "layers, found more: is it a volume of labels?",
                                  name(), options_.max_labels));
        }
        FoundLabel& label = labels_.emplace_back();
        label.value = value;
        label.index = at->second = static_cast<uint16_t>(labels_.size());
        label.low = header_.grid.voxels;
        label.high = {-1, -1, -1};
      }
      index = at->second;
    }
    is_known_ = true;
    last_value_ = found;
    last_index_ = index;
    return index;
  }

  VolumeSource& source_;
  const VolumeHeader& header_;
  LabelRows& rows_;
  const LabelScanOptions& options_;
  std::vector<FoundLabel> labels_;  ///< by index − 1
  std::unordered_map<int64_t, uint16_t> indices_;
  bool is_known_ = false;
  double last_value_ = 0;
  uint16_t last_index_ = 0;
};

}  // namespace

Result<std::vector<FoundLabel>> scan_labels(VolumeSource& source, LabelRows& rows,
                                            const LabelScanOptions& options) {
  return LabelScan(source, rows, options).run();
}

}  // namespace isosplat
