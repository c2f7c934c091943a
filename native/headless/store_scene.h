#pragma once

#include <array>
#include <optional>
#include <span>

#include "shared/render/renderer.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {

/// The chunks that show_store() has uploaded.
struct StoreScene {
  uint32_t level = 0;
  uint64_t chunks = 0;
  uint64_t samples = 0;
  /// Of the field, in the cells of the isosurfaces: FieldCounts::percentiles.
  std::optional<std::array<double, 2>> field_range;
};

/// The number and the grid of a store in a picture of several volumes.
struct VolumePlace {
  render::VolumeId volume = 0;
  std::optional<VolumeGrid> grid;  ///< after the transform of its layer
  /// A field of the store (open_field), whose values are uploaded with the chunks. Null: none.
  const StoreFile* field = nullptr;
};

/// Uploads the chunks of a store that the isovalues need at one level, and makes them visible.
/// Without a level: the finest level from `finest` on with at most `sample_budget` samples, or the
/// coarsest level.
/// `placed`: the volume's number in the picture, and its grid in the picture if that differs from
/// the store's grid; and its field. `reads_ahead`: the reads that run while a chunk is decoded; 0:
/// each waits for the one before. Errors: not_found (no such level), those of StoreFile,
/// ChunkDecoder and Renderer::add_chunk.
Result<StoreScene> show_store(render::Renderer& renderer, const StoreFile& store,
                              std::span<const double> isovalues, std::optional<uint32_t> level,
                              uint64_t sample_budget, uint32_t finest = 0,
                              const VolumePlace& placed = {}, unsigned reads_ahead = 0);

}  // namespace isosplat
