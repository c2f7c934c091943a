#include "shared/render/samples/chunk_store.h"

#include <cmath>
#include <string>
#include <utility>

namespace isosplat::render {

Result<void> ChunkStore::check_block(const VolumeGrid& grid, const BlockKey& block) {
  if (block.level >= level_count(grid.voxels)) {
    return fail(Status::invalid_argument,
                "the volume has no level " + std::to_string(block.level) + ", which a chunk names");
  }
  const Index3 blocks = level_grid(grid.voxels, block.level).blocks, at = block.index;
  if (at.x < 0 || at.y < 0 || at.z < 0 || at.x >= blocks.x || at.y >= blocks.y ||
      at.z >= blocks.z) {
    return fail(Status::invalid_argument, "a chunk's block lies outside of the volume");
  }
  return {};
}

SampleRange ChunkStore::reserve(const VolumeGrid& grid, ChunkHandle handle, const BlockKey& block,
                                std::vector<SampleCluster> clusters) {
  Chunk chunk{{}, block, {kMissingVoxel, 0}, {}, {}, std::move(clusters)};
  const uint32_t count =
      chunk.clusters.empty() ? 0 : chunk.clusters.back().first + chunk.clusters.back().count;
  const SampleRange range = buffers_.reserve(count);
  chunk.range = range;
  for (const SampleCluster& cluster : chunk.clusters) {
    chunk.interval.min = std::min(chunk.interval.min, cluster.interval.min);
    chunk.interval.max = std::max(chunk.interval.max, cluster.interval.max);
  }
  const Index3 at = block.index;
  const Index3 cells = block_cells(level_grid(grid.voxels, block.level), at);
  const double cell = std::ldexp(1.0, static_cast<int>(block.level));
  chunk.low = Vec3d{double(at.x), double(at.y), double(at.z)} * (cell * kBlockCells);
  chunk.high = chunk.low + Vec3d{double(cells.x), double(cells.y), double(cells.z)} * cell;
  chunks_.emplace(handle, std::move(chunk));
  return range;
}

bool ChunkStore::remove(ChunkHandle handle) {
  const auto found = chunks_.find(handle);
  if (found == chunks_.end()) return false;
  buffers_.remove(found->second.range);
  chunks_.erase(found);
  return true;
}

void ChunkStore::clear() {
  for (const auto& [handle, chunk] : chunks_) buffers_.remove(chunk.range);
  chunks_.clear();
  visible_.clear();
}

void ChunkStore::drop_unconfirmed() {
  std::erase_if(chunks_, [this](const auto& entry) {
    const SampleRange& range = entry.second.range;
    if (buffers_.is_confirmed(range)) return false;
    buffers_.remove(range);
    return true;
  });
}

const ChunkStore::Chunk* ChunkStore::find(ChunkHandle handle) const {
  const auto found = chunks_.find(handle);
  return found == chunks_.end() ? nullptr : &found->second;
}

bool ChunkStore::set_visible(std::span<const DrawnChunk> chunks) {
  if (std::equal(chunks.begin(), chunks.end(), visible_.begin(), visible_.end())) return false;
  visible_.assign(chunks.begin(), chunks.end());
  return true;
}

void ChunkStore::abandon() {
  chunks_.clear();
  visible_.clear();
}

}  // namespace isosplat::render
