#include "shared/render/frame/draw_list.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

double cells_per_cell_of_level_0(const ChunkStore::Chunk& chunk) {
  return std::ldexp(1.0, static_cast<int>(chunk.block.level));
}

/// The box around the regions of a chunk that are drawn, in frame space.
Frame::Box drawn_box(const DrawnChunk& visible, const ChunkStore::Chunk& chunk,
                     const Frame& frame) {
  Index3 low{kBlockRegions, kBlockRegions, kBlockRegions}, high{0, 0, 0};
  for (int32_t i = 0; i < kBlockRegions * kBlockRegions * kBlockRegions; ++i) {
    const Index3 at{i % kBlockRegions, i / kBlockRegions % kBlockRegions,
                    i / (kBlockRegions * kBlockRegions)};
    if (!visible.regions.contains(at)) continue;
    low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
    high = {std::max(high.x, at.x + 1), std::max(high.y, at.y + 1), std::max(high.z, at.z + 1)};
  }
  if (high.x == 0) return frame.box(chunk.low, chunk.high);
  const double region = cells_per_cell_of_level_0(chunk) * kBlockCells / kBlockRegions;
  const auto cells = [&](Index3 at) {
    return chunk.low + Vec3d{double(at.x), double(at.y), double(at.z)} * region;
  };
  const Vec3d end = cells(high);
  return frame.box(cells(low), {std::min(end.x, chunk.high.x), std::min(end.y, chunk.high.y),
                                std::min(end.z, chunk.high.z)});
}

DrawItem make_item(const DrawnChunk& visible, const ChunkStore::Chunk& chunk, const Frame& frame,
                   const Frame::Box& box) {
  const double level_scale = cells_per_cell_of_level_0(chunk);
  // Of a coarse chunk, the nearest regions are often those where finer chunks are drawn.
  const bool is_whole = visible.regions == RegionMask::all();
  const double nearest = frame.nearest(is_whole ? box : drawn_box(visible, chunk, frame));
  const double diagonal = 2 * level_scale * double(frame.block().displacement_threshold);
  // Near the corners of the image, oblique cells look larger than their diagonal.
  const double largest_px =
      1.5 * diagonal * double(frame.block().splat_scale) * frame.px_per_unit(nearest - diagonal);
  constexpr double kReach = 2 * double(SMOOTH_REACH_CELLS);  // of a splat of gradients, in cells
  const double largest_support_px =
      1.5 * kReach * diagonal * frame.px_per_unit(nearest - kReach * diagonal);
  const double largest_side_px = level_scale * frame.cell_side() * frame.px_per_unit(nearest);
  const Vec3d corner = box.centre - box.half;
  return {visible.handle,
          &chunk,
          nearest,
          {static_cast<float>(corner.x), static_cast<float>(corner.y), static_cast<float>(corner.z),
           static_cast<float>(level_scale)},
          visible.regions,
          static_cast<float>(largest_px),
          static_cast<float>(largest_support_px),
          static_cast<float>(largest_side_px),
          0};
}

/// The bounding box of a cluster's cells, in frame space.
Occluders::Box cluster_box(const Frame& frame, const DrawItem& item, const SampleCluster& cluster) {
  const auto& s = frame.block().cell_edges;
  const auto& [x, y, z, scale] = item.block;
  const Vec3f size = Vec3f{s[0], s[1], s[2]} * scale;
  const auto along = [](uint8_t low, uint8_t high, float from, float cell) {
    return std::pair{from + 0.5f * cell * static_cast<float>(low + high),
                     0.5f * cell * static_cast<float>(high - low)};
  };
  const auto [cx, hx] = along(cluster.low.x, cluster.high.x, x, size.x);
  const auto [cy, hy] = along(cluster.low.y, cluster.high.y, y, size.y);
  const auto [cz, hz] = along(cluster.low.z, cluster.high.z, z, size.z);
  return {{cx, cy, cz}, {hx, hy, hz}};
}

Frame::Box in_double(const Occluders::Box& box) {
  const auto to_double = [](Vec3f v) { return Vec3d{double(v.x), double(v.y), double(v.z)}; };
  return {to_double(box.centre), to_double(box.half)};
}

}  // namespace

/// Makes visible the clusters for which `is_present` returns true. Calls it once for each cluster.
template <typename IsPresent>
void DrawList::find_visible(IsPresent is_present) {
  visibilities_.clear();
  for (DrawItem& item : items_) {
    item.first_cluster = static_cast<uint32_t>(visibilities_.size());
    for (const SampleCluster& cluster : item.chunk->clusters) {
      visibilities_.push_back(is_present(item, cluster) ? ClusterVisibility::visible
                                                        : ClusterVisibility::absent);
    }
  }
}

uint32_t DrawList::collect(const ChunkStore& chunks, const Frame& frame, double margin_cells) {
  items_.clear();
  finest_level_ = kNoLevel;
  uint32_t culled = 0;
  for (const DrawnChunk& visible : chunks.visible()) {
    const ChunkStore::Chunk* chunk = chunks.find(visible.handle);
    if (!chunk || chunk->range.count == 0) continue;
    const Frame::Box box = frame.box(chunk->low, chunk->high);
    const double margin = margin_cells * cells_per_cell_of_level_0(*chunk);
    const Vec3d margins{margin, margin, margin};
    const Frame::Box around = frame.box(chunk->low - margins, chunk->high + margins);
    const bool is_seen = frame.may_see(around);
    if (is_seen || frame.may_see_in_image(around)) {
      finest_level_ = std::min(finest_level_, chunk->block.level);
    }
    if (is_seen) {
      items_.push_back(make_item(visible, *chunk, frame, box));
    } else {
      ++culled;
    }
  }
  std::sort(items_.begin(), items_.end(),
            [](const DrawItem& a, const DrawItem& b) { return a.nearest < b.nearest; });
  return culled;
}

uint64_t DrawList::estimate_visibility(const Frame& frame, float quantized_isovalue) {
  occluders_.begin(frame.block());
  const auto side = static_cast<float>(frame.cell_side());
  find_visible([&](const DrawItem& item, const SampleCluster& cluster) {
    const auto box = cluster_box(frame, item, cluster);
    const bool present = is_active(cluster.interval, quantized_isovalue) &&
                         item.regions.contains(cluster.region_index()) &&
                         occluders_.is_in_image(box, item.largest_px);
    if (present) {
      const float cell = item.block[3] * side;
      const float area = float(OCCLUDER_FILL) * static_cast<float>(cluster.count) * cell * cell;
      occluders_.add(box, area);
    }
    return present;
  });
  uint64_t occluded_samples = 0;
  for (const DrawItem& item : items_) {
    for (size_t i = 0; i < item.chunk->clusters.size(); ++i) {
      ClusterVisibility& visibility = visibilities_[item.first_cluster + i];
      const SampleCluster& cluster = item.chunk->clusters[i];
      if (visibility == ClusterVisibility::absent ||
          !occluders_.occlude(cluster_box(frame, item, cluster))) {
        continue;
      }
      visibility = ClusterVisibility::occluded;
      occluded_samples += cluster.count;
    }
  }
  return occluded_samples;
}

void DrawList::drop_occluded(const Frame& frame, std::span<const float> depths) {
  occluders_.set_drawn(depths);
  for (const DrawItem& item : items_) {
    for (size_t i = 0; i < item.chunk->clusters.size(); ++i) {
      ClusterVisibility& visibility = visibilities_[item.first_cluster + i];
      if (visibility == ClusterVisibility::occluded &&
          occluders_.occlude(cluster_box(frame, item, item.chunk->clusters[i]))) {
        visibility = ClusterVisibility::absent;
      }
    }
  }
}

void DrawList::find_contributors(const Frame& frame) {
  occluders_.begin(frame.block());
  find_visible([&](const DrawItem& item, const SampleCluster& cluster) {
    return item.regions.contains(cluster.region_index()) &&
           occluders_.is_in_image(cluster_box(frame, item, cluster), item.largest_support_px);
  });
}

void DrawList::find_active(const Frame& frame, float quantized_isovalue) {
  occluders_.begin(frame.block());
  find_visible([&](const DrawItem& item, const SampleCluster& cluster) {
    return is_active(cluster.interval, quantized_isovalue) &&
           item.regions.contains(cluster.region_index()) &&
           occluders_.is_in_image(cluster_box(frame, item, cluster), item.largest_px);
  });
}

void DrawList::find_cut(const Frame& frame, float quantized_isovalue) {
  occluders_.begin(frame.block());
  find_visible([&](const DrawItem& item, const SampleCluster& cluster) {
    const auto box = cluster_box(frame, item, cluster);
    return is_active(cluster.interval, quantized_isovalue) &&
           item.regions.contains(cluster.region_index()) && frame.may_cut(in_double(box)) &&
           occluders_.is_in_image(box, item.largest_px);
  });
}

void DrawList::collect_cut(const ChunkStore& chunks, const Frame& frame, const Plane& plane) {
  const auto is_cut = [&](const Frame::Box& box) {
    return Frame::is_near(box, plane, double(SLICE_MARGIN)) && frame.may_see(box);
  };
  items_.clear();
  uint32_t levels = 0;
  for (const auto& [handle, chunk] : chunks.all()) levels = std::max(levels, chunk.block.level + 1);
  for (uint32_t level = levels; level-- > 0;) {
    for (const auto& [handle, chunk] : chunks.all()) {
      if (chunk.block.level != level || chunk.range.count == 0) continue;
      const Frame::Box box = frame.box(chunk.low, chunk.high);
      if (is_cut(box)) items_.push_back(make_item({handle}, chunk, frame, box));
    }
  }
  find_visible([&](const DrawItem& item, const SampleCluster& cluster) {
    return is_cut(in_double(cluster_box(frame, item, cluster)));
  });
}

const DrawItem* DrawList::find(ChunkHandle handle) const {
  const auto found = std::find_if(items_.begin(), items_.end(),
                                  [handle](const DrawItem& item) { return item.handle == handle; });
  return found == items_.end() ? nullptr : &*found;
}

}  // namespace isosplat::render
