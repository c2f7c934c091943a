#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/sampling/cell.h"
#include "shared/core/sampling/packed_sample.h"

namespace isosplat {

struct CellMask;

/// The properties of a chunk that the directory of the store holds. Encoder and decoder need the
/// same values, except for the cell count, which only the decoder needs.
struct ChunkShape {
  Index3 block_cells;          ///< of its block, each 1 to kBlockCells
  uint32_t band_begin = 0;     ///< the first quantized value of the band
  uint32_t band_end = 0;       ///< one beyond its last, > band_begin, ≤ 65535
  uint32_t cell_count = 0;     ///< cells that the chunk holds, ≥ 1
  bool has_intervals = false;  ///< levels ≥ 1: the cells' intervals go beyond their corners'
};

/// A block to encode. Borrowed during the call.
struct BlockVoxels {
  Index3 cells;                            ///< each 1 to kBlockCells
  const QuantizedValue* voxels = nullptr;  ///< (cells.x + 1)(cells.y + 1)(cells.z + 1), x fastest
  /// One per cell, x fastest. Level 0: the range of the cell's corners; coarser levels: the true
  /// interval. Cells with min ≥ max (such as those with a missing corner) are never active.
  const CellInterval* intervals = nullptr;
  bool has_intervals = false;  ///< levels ≥ 1: the intervals are coded, not taken from the corners
  /// For each row of cells (y fastest, then z) an interval that contains those of its cells, so
  /// that rows outside a band can be skipped. Null: unknown.
  const CellInterval* row_intervals = nullptr;
  /// The corners alone determine the surface in each cell (CHUNK.md). Requires values below 256.
  bool corners_suffice = false;
};

/// The cells of a chunk in raster order (x fastest): three arrays of one length.
struct DecodedCells {
  std::vector<uint32_t> cell;  ///< index in the block, x | y << 6 | z << 12
  std::vector<CellCorners> corners;
  std::vector<CellInterval> interval;
};

/// Encodes chunks (layout: CHUNK.md). Deterministic: the same bytes on every machine. Keeps scratch
/// memory between calls, so use one per thread.
class ChunkEncoder {
 public:
  ChunkEncoder();
  ChunkEncoder(ChunkEncoder&&) noexcept;
  ChunkEncoder& operator=(ChunkEncoder&&) noexcept;
  ~ChunkEncoder();

  /// Appends to `out` the chunk of every cell that is active for some quantized isovalue in
  /// [band_begin, band_end), i.e. max(min, band_begin) < min(max, band_end). Returns the number of
  /// those cells; appends nothing if there are none.
  uint32_t encode(const BlockVoxels& block, uint32_t band_begin, uint32_t band_end,
                  std::vector<std::byte>& out);

  /// The same for cells that are known: BandMasks finds the cells of all bands at once.
  uint32_t encode(const BlockVoxels& block, const CellMask& cells, uint32_t band_begin,
                  uint32_t band_end, std::vector<std::byte>& out);

  /// Appends a field chunk: the values of a field at the corners of these cells, without the mask,
  /// which the chunk of the cells has. Reads only `cells` and `voxels` of the block. value_end:
  /// above all values, 256 or 65536. Appends nothing if there are no cells.
  void encode_field(const BlockVoxels& field, const CellMask& cells, uint32_t value_end,
                    std::vector<std::byte>& out);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

/// Decodes chunks. The bytes are untrusted: a call returns exactly shape.cell_count cells, or an
/// error. Keeps scratch memory between calls (about 2 MB), so use one per thread.
///
/// Errors of all calls: truncated (the bytes end too early), malformed_chunk (anything else),
/// invalid_argument (the shape is outside its limits).
class ChunkDecoder {
 public:
  ChunkDecoder();
  ChunkDecoder(ChunkDecoder&&) noexcept;
  ChunkDecoder& operator=(ChunkDecoder&&) noexcept;
  ~ChunkDecoder();

  /// Replaces the content of `out`; after an error it is empty.
  Result<void> decode(std::span<const std::byte> bytes, const ChunkShape& shape, DecodedCells& out);

  /// The same cells as decode(), each through pack_sample(), which is faster. Where the corners
  /// suffice, each cell's interval is that of its corners. Replaces the content of `out`.
  Result<void> decode_packed(std::span<const std::byte> bytes, const ChunkShape& shape,
                             std::vector<PackedSample>& out);

  /// Decodes a field chunk: the values of a field at the corners of each of `cells`, which are all
  /// cells of the chunk that it belongs to (DecodedCells::cell). value_end: see encode_field.
  /// Replaces the content of `out`; after an error it is empty. Errors also: invalid_argument where
  /// the cells do not ascend, or lie outside the block.
  Result<void> decode_field(std::span<const std::byte> bytes, Index3 block_cells,
                            std::span<const uint32_t> cells, uint32_t value_end,
                            std::vector<CellCorners>& out);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace isosplat
