#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/drawn_chunk.h"
#include "shared/core/grid/grid.h"
#include "shared/core/sampling/sample_clusters.h"
#include "shared/render/samples/sample_buffers.h"

namespace isosplat::render {

/// The resident chunks of a volume by handle: their clusters, the location of their samples in the
/// GPU buffers of all volumes, and which of them are visible.
class ChunkStore {
 public:
  struct Chunk {
    SampleRange range;
    BlockKey block;
    CellInterval interval;  ///< of all samples: min of mins, max of maxes
    Vec3d low, high;        ///< bounding box in cells of level 0
    std::vector<SampleCluster> clusters;
    bool has_field = false;  ///< whether its samples have values of the volume's field
  };

  /// The buffers must outlive the store.
  explicit ChunkStore(SampleBuffers& buffers) : buffers_(buffers) {}
  ~ChunkStore() { clear(); }
  ChunkStore(const ChunkStore&) = delete;
  ChunkStore& operator=(const ChunkStore&) = delete;

  /// Checks that the volume has this block. Errors: invalid_argument.
  static Result<void> check_block(const VolumeGrid& grid, const BlockKey& block);

  /// Adds a chunk whose block check_block() accepts, and whose clusters are valid. The handle must
  /// not be in use. The caller uploads the samples: see SampleBuffers::reserve.
  SampleRange reserve(const VolumeGrid& grid, ChunkHandle handle, const BlockKey& block,
                      std::vector<SampleCluster> clusters);
  /// Makes room for the field values of a chunk's samples, unless it has values, and binds their
  /// buffer: see SampleBuffers::reserve_field. The handle is in use. Returns the range of the
  /// samples.
  SampleRange reserve_field(ChunkHandle handle);
  /// Removes the field values of all chunks.
  void clear_fields();
  /// Removes a chunk. Returns false if there is none with this handle.
  bool remove(ChunkHandle handle);
  /// Removes all chunks, and keeps the buffers.
  void clear();
  /// Removes the chunks, and the field values, in buffers that are not confirmed.
  void drop_unconfirmed();

  /// The chunk with this handle, or null. Valid until it is removed.
  const Chunk* find(ChunkHandle handle) const;

  const std::unordered_map<ChunkHandle, Chunk>& all() const { return chunks_; }

  /// Chunks to draw; handles need not be resident. Returns false if the list has not changed.
  bool set_visible(std::span<const DrawnChunk> chunks);
  const std::vector<DrawnChunk>& visible() const { return visible_; }
  bool is_visible(ChunkHandle handle) const {
    return std::any_of(visible_.begin(), visible_.end(),
                       [handle](const DrawnChunk& chunk) { return chunk.handle == handle; });
  }

  const SampleBuffers& buffers() const { return buffers_; }

  /// The context that owned the buffers is gone, and with it all chunks.
  void abandon();

 private:
  void free_samples(const Chunk& chunk);

  std::unordered_map<ChunkHandle, Chunk> chunks_;
  std::vector<DrawnChunk> visible_;
  SampleBuffers& buffers_;
};

}  // namespace isosplat::render
