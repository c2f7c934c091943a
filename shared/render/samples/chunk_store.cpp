#include "shared/render/samples/chunk_store.h"

#include <cmath>
#include <iterator>
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

SampleRange ChunkStore::reserve_field(ChunkHandle handle) {
  Chunk& chunk = chunks_.at(handle);
  if (chunk.has_field) {
    buffers_.bind_field(chunk.range);
  } else {
    buffers_.reserve_field(chunk.range);
  }
  chunk.has_field = true;
  return chunk.range;
}

void ChunkStore::clear_fields() {
  for (auto& [handle, chunk] : chunks_) {
    if (chunk.has_field) buffers_.remove_field(chunk.range);
    chunk.has_field = false;
  }
}

void ChunkStore::free_samples(const Chunk& chunk) {
  if (chunk.has_field) buffers_.remove_field(chunk.range);
  buffers_.remove(chunk.range);
}

bool ChunkStore::remove(ChunkHandle handle) {
  const auto found = chunks_.find(handle);
  if (found == chunks_.end()) return false;
  free_samples(found->second);
  chunks_.erase(found);
  return true;
}

void ChunkStore::clear() {
  for (const auto& [handle, chunk] : chunks_) free_samples(chunk);
  chunks_.clear();
  visible_.clear();
}

void ChunkStore::drop_unconfirmed() {
  for (auto each = chunks_.begin(); each != chunks_.end();) {
    Chunk& chunk = each->second;
    if (chunk.has_field && !buffers_.is_field_confirmed(chunk.range)) {
      buffers_.remove_field(chunk.range);
      chunk.has_field = false;
    }
    const bool has_memory = buffers_.is_confirmed(chunk.range);
    if (!has_memory) free_samples(chunk);
    each = has_memory ? std::next(each) : chunks_.erase(each);
  }
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
