#include "shared/import/dicom/segment_pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "shared/import/dicom/pixels.h"

namespace isosplat::import::dicom {
namespace {

/// Frames are read in batches of this many bytes, or one by one: each batch of compressed frames
/// starts a child process.
constexpr size_t kBatchBytes = size_t{32} << 20;

/// The largest number of segments with a common pixel.
constexpr size_t kMaxDepth = 64;

/// Turns the voxels of a frame into 1 (inside) and 0.
void find_inside(VoxelType type, std::span<const std::byte> voxels, double threshold,
                 std::span<uint8_t> inside) {
  with_voxel_type(type, [&]<class T>(T) {
    for (size_t i = 0; i < inside.size(); ++i) {
      T voxel;
      std::memcpy(&voxel, voxels.data() + i * sizeof(T), sizeof(T));
      inside[i] = static_cast<double>(voxel) >= threshold ? 1 : 0;  // 0 for absent voxels, NaN
    }
  });
}

/// Finds which segments have a pixel in common.
class Overlaps {
 public:
  Overlaps(size_t segments, size_t pixels, size_t max_depth)
      : segments_(segments),
        pixels_(pixels),
        max_depth_(max_depth),
        overlaps_(segments * segments) {}

  void begin_slice() {
    for (auto& layer : layers_) std::fill(layer.begin(), layer.end(), uint16_t{0});
  }

  /// False if more than max_depth segments have a common pixel.
  bool add(uint16_t segment, std::span<const uint8_t> inside) {
    for (size_t i = 0; i < pixels_; ++i) {
      if (!inside[i]) continue;
      size_t depth = 0;
      for (; depth < layers_.size() && layers_[depth][i] != 0; ++depth) {
        const size_t other = layers_[depth][i] - 1u;
        overlaps_[segment * segments_ + other] = overlaps_[other * segments_ + segment] = true;
      }
      if (depth == max_depth_) return false;
      if (depth == layers_.size()) layers_.emplace_back(pixels_);
      layers_[depth][i] = static_cast<uint16_t>(segment + 1);
    }
    return true;
  }

  std::vector<uint16_t> groups() const {
    std::vector<uint16_t> groups(segments_);
    std::vector<bool> is_taken;
    for (size_t i = 0; i < segments_; ++i) {
      is_taken.assign(i + 1, false);
      for (size_t k = 0; k < i; ++k) {
        if (overlaps_[i * segments_ + k]) is_taken[groups[k]] = true;
      }
      groups[i] = static_cast<uint16_t>(std::find(is_taken.begin(), is_taken.end(), false) -
                                        is_taken.begin());
    }
    return groups;
  }

 private:
  size_t segments_, pixels_, max_depth_;
  std::vector<bool> overlaps_;                 ///< segments × segments
  std::vector<std::vector<uint16_t>> layers_;  ///< of a slice: segment + 1, or 0
};

}  // namespace

Result<void> SegmentPixels::read(size_t first, size_t count,
                                 const std::function<bool(uint16_t)>& wanted,
                                 const Use& use) const {
  struct Wanted {
    size_t slice;
    const SegmentFrame* frame;
  };
  std::vector<Wanted> frames;
  for (size_t z = first; z < first + count; ++z) {
    for (const SegmentFrame& frame : slices[z]) {
      if (wanted(frame.segment)) frames.push_back({z, &frame});
    }
  }
  const size_t area =
      static_cast<size_t>(images.front().columns) * static_cast<size_t>(images.front().rows);
  const size_t bytes = area * voxel_bytes(type);
  const size_t batch = std::max<size_t>(kBatchBytes / bytes, 1);
  std::vector<std::byte> voxels;
  std::vector<uint8_t> inside(area);
  for (size_t begin = 0; begin < frames.size(); begin += batch) {
    const auto some = std::span(frames).subspan(begin, std::min(batch, frames.size() - begin));
    std::vector<FramePixels> of;
    for (const Wanted& each : some) {
      FramePixels frame;
      frame.image = &images[each.frame->image];
      frame.index = each.frame->index;
      of.push_back(frame);
    }
    voxels.resize(bytes * some.size());
    if (auto r = read_frames(of, type, fill_missing, memory_bytes, voxels); !r) return r;
    for (size_t i = 0; i < some.size(); ++i) {
      find_inside(type, std::span(voxels).subspan(i * bytes, bytes), threshold, inside);
      if (auto r = use(some[i].slice, some[i].frame->segment, inside); !r) return r;
    }
  }
  return {};
}

Result<std::vector<uint16_t>> groups_without_overlap(const SegmentPixels& pixels, size_t count,
                                                     const std::filesystem::path& path,
                                                     uint64_t memory_bytes) {
  if (count == 1) return std::vector<uint16_t>{0};
  const size_t area = static_cast<size_t>(pixels.images.front().columns) *
                      static_cast<size_t>(pixels.images.front().rows);
  const auto max_depth = static_cast<size_t>(
      std::clamp<uint64_t>(memory_bytes / 4 / (area * sizeof(uint16_t)), 2, kMaxDepth));
  Overlaps overlaps(count, area, max_depth);
  size_t last = pixels.slices.size();
  const auto read = pixels.read(
      0, pixels.slices.size(), [](uint16_t) { return true; },
      [&](size_t slice, uint16_t segment, std::span<const uint8_t> inside) -> Result<void> {
        if (slice != last) overlaps.begin_slice();
        last = slice;
        if (overlaps.add(segment, inside)) return {};
        return fail(Status::unsupported_format,
                    fmt::format("{}: expected at most {} segments with a common pixel, found more: "
                                "choose one with --segment",
                                path.string(), max_depth));
      });
  if (!read) return tl::unexpected(read.error());
  return overlaps.groups();
}

}  // namespace isosplat::import::dicom
