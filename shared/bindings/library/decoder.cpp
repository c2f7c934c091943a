#include "isosplat/decoder.h"

#include "shared/bindings/library/convert.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/points/chunk_samples.h"
#include "shared/core/store/checksum.h"

namespace isosplat {

struct Cells::State {
  VolumeGrid grid;
  ValueMapping mapping;
  BlockKey block;
  DecodedCells cells;

  ChunkFrame frame() const { return {&grid, &mapping, block}; }
};

Cells::Cells() : state_(std::make_unique<State>()) {}
Cells::Cells(Cells&&) noexcept = default;
Cells& Cells::operator=(Cells&&) noexcept = default;
Cells::~Cells() = default;

size_t Cells::size() const {
  return state_->cells.cell.size();
}

SampleArrays Cells::samples() const {
  return samples_of(state_->cells, state_->frame());
}

PointArrays Cells::project(double isovalue, const ProjectionOptions& options) const {
  return project_samples(state_->cells, state_->frame(),
                         state_->mapping.quantized_isovalue(isovalue), options);
}

struct Decoder::State {
  VolumeGrid grid;
  ValueMapping mapping;
  uint32_t levels;
  ChunkDecoder decoder;
};

Decoder::Decoder(const Volume& volume)
    : state_(std::make_unique<State>(
          State{grid_of(volume), mapping_of(volume), volume.levels, ChunkDecoder()})) {}
Decoder::Decoder(Decoder&&) noexcept = default;
Decoder& Decoder::operator=(Decoder&&) noexcept = default;
Decoder::~Decoder() = default;

namespace {

bool contains(Index3 end, Index3 index) {
  return index.x >= 0 && index.y >= 0 && index.z >= 0 && index.x < end.x && index.y < end.y &&
         index.z < end.z;
}

}  // namespace

Result<void> Decoder::decode(const Chunk& chunk, std::span<const std::byte> bytes, Cells& cells) {
  const Index3 voxels = state_->grid.voxels;
  if (chunk.level >= state_->levels || chunk.level >= level_count(voxels)) {
    return fail(Status::invalid_argument, "expected a chunk of a level below " +
                                              std::to_string(state_->levels) + ", found " +
                                              std::to_string(chunk.level));
  }
  const LevelGrid level = level_grid(voxels, chunk.level);
  if (!contains(level.blocks, chunk.block)) {
    return fail(Status::invalid_argument, "the volume has no block at the chunk's index");
  }
  if (bytes.size() != chunk.bytes) {
    return fail(Status::truncated, "expected the " + std::to_string(chunk.bytes) +
                                       " bytes of a chunk, found " + std::to_string(bytes.size()));
  }
  if (checksum32(bytes) != chunk.checksum) {
    return fail(Status::checksum_mismatch,
                "a chunk's checksum differs: rebuild the store, or fetch it again");
  }
  Cells::State& out = *cells.state_;
  out.grid = state_->grid;
  out.mapping = state_->mapping;
  out.block = {chunk.level, chunk.block};
  const ChunkShape shape{block_cells(level, chunk.block), chunk.band_begin, chunk.band_end,
                         chunk.cells, chunk.level > 0};
  return state_->decoder.decode(bytes, shape, out.cells);
}

}  // namespace isosplat
