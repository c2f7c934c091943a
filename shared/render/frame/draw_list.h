#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "shared/render/frame/frame.h"
#include "shared/render/frame/occluders.h"
#include "shared/render/samples/chunk_store.h"

namespace isosplat::render {

/// Which clusters a pass draws. The last one needs a depth test in the vertex shader, which drops
/// samples that are occluded by surfaces drawn before.
enum class ClusterSubset : uint8_t { all, likely_visible, likely_occluded };

/// A visible chunk in the frustum of this frame.
struct DrawItem {
  ChunkHandle handle;
  const ChunkStore::Chunk* chunk;
  double nearest;              ///< distance along the view of its nearest point, frame space
  std::array<float, 4> block;  ///< u_block of shaders/block.glsl
  RegionMask regions;
  float largest_px;          ///< upper limit of the size of its splats
  float largest_support_px;  ///< that of splats of gradients
  float largest_side_px;     ///< upper limit of the side of a cell (as a cube of its volume)
  uint32_t first_cluster;    ///< of its clusters in the list of all clusters
};

/// The chunks to draw in a frame, and an estimate of which of their clusters are occluded.
class DrawList {
 public:
  /// Collects the visible chunks inside of the frustum and the clip planes, or at most
  /// `margin_cells` of their cells outside, nearest first. Returns the number of resident visible
  /// chunks that are not collected.
  uint32_t collect(const ChunkStore& chunks, const Frame& frame, double margin_cells);

  /// Estimates, for one isosurface, which clusters are in the image and which of them are occluded
  /// by others. Returns the number of samples in the occluded ones.
  uint64_t estimate_visibility(const Frame& frame, float quantized_isovalue);

  /// After estimate_visibility(): of the clusters that it found occluded, keeps those that are not
  /// behind the depths drawn so far: the farthest one of each square of OCCLUDER_PX, from the
  /// bottom row of the image on.
  void drop_occluded(const Frame& frame, std::span<const float> depths);

  /// An alternative to estimate_visibility(): finds all clusters whose cells may contribute to the
  /// normals of surfaces in the image.
  void find_contributors(const Frame& frame);

  /// An alternative to estimate_visibility(): finds all active clusters in the image that a clip
  /// plane may cut.
  void find_cut(const Frame& frame, float quantized_isovalue);

  /// An alternative to estimate_visibility(): finds all active clusters in the image.
  void find_active(const Frame& frame, float quantized_isovalue);

  /// An alternative to collect() and estimate_visibility(). Collects all resident chunks, visible
  /// or not, that a plane of frame space cuts in the image, the coarsest first. In these chunks,
  /// finds the clusters that the plane cuts.
  void collect_cut(const ChunkStore& chunks, const Frame& frame, const Plane& plane);

  const std::vector<DrawItem>& items() const { return items_; }
  const DrawItem* find(ChunkHandle handle) const;
  /// The finest level of the chunks in the whole image; 0 if there are none.
  uint32_t finest_level() const { return finest_level_ == kNoLevel ? 0 : finest_level_; }

  /// Calls draw(first, count) for each range of consecutive samples of the chunk that a subset
  /// contains.
  template <typename Draw>
  void for_each_range(const DrawItem& item, ClusterSubset subset, Draw draw) const;

  /// Calls visit(cluster) for each cluster of the chunk that was found.
  template <typename Visit>
  void for_each_cluster(const DrawItem& item, Visit visit) const;

  void clear() { items_.clear(); }

 private:
  /// Estimated visibility of a cluster; absent: inactive, not in the chunk's drawn regions, or
  /// outside of the image.
  enum class ClusterVisibility : uint8_t { absent, visible, occluded };

  template <typename IsPresent>
  void find_visible(IsPresent is_present);
  static bool contains(ClusterSubset subset, ClusterVisibility visibility);

  // Reused between frames, to avoid allocations.
  std::vector<DrawItem> items_;
  std::vector<ClusterVisibility> visibilities_;  // of the clusters of all items
  Occluders occluders_;
  static constexpr uint32_t kNoLevel = std::numeric_limits<uint32_t>::max();
  uint32_t finest_level_ = kNoLevel;
};

inline bool DrawList::contains(ClusterSubset subset, ClusterVisibility visibility) {
  switch (subset) {
    case ClusterSubset::likely_visible:
      return visibility == ClusterVisibility::visible;
    case ClusterSubset::likely_occluded:
      return visibility == ClusterVisibility::occluded;
    case ClusterSubset::all:
      break;
  }
  return visibility != ClusterVisibility::absent;
}

template <typename Draw>
void DrawList::for_each_range(const DrawItem& item, ClusterSubset subset, Draw draw) const {
  uint32_t first = 0, count = 0;
  const auto& clusters = item.chunk->clusters;
  for (size_t i = 0; i < clusters.size(); ++i) {
    if (!contains(subset, visibilities_[item.first_cluster + i])) continue;
    if (count > 0 && clusters[i].first == first + count) {
      count += clusters[i].count;
      continue;
    }
    if (count > 0) draw(first, count);
    first = clusters[i].first;
    count = clusters[i].count;
  }
  if (count > 0) draw(first, count);
}

template <typename Visit>
void DrawList::for_each_cluster(const DrawItem& item, Visit visit) const {
  const auto& clusters = item.chunk->clusters;
  for (size_t i = 0; i < clusters.size(); ++i) {
    if (contains(ClusterSubset::all, visibilities_[item.first_cluster + i])) visit(clusters[i]);
  }
}

}  // namespace isosplat::render
