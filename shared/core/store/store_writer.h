#pragma once

#include <memory>
#include <span>
#include <vector>

#include "shared/core/store/store_reader.h"

namespace isosplat {

/// The destination of a store's bytes: a file or memory. The writer first writes everything after
/// the header, in ascending order without gaps, and then the header at offset 0.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Errors: io_error.
  virtual Result<void> write(uint64_t offset, std::span<const std::byte> bytes) = 0;
};

/// A sink in memory, for tests and small stores.
class MemorySink : public ByteSink {
 public:
  Result<void> write(uint64_t offset, std::span<const std::byte> bytes) override;
  std::vector<std::byte> bytes;
};

/// One encoded band of a block.
struct BandChunk {
  uint32_t band_end = 0;  ///< the begin is the end of the band before, or the block's min
  uint32_t cells = 0;
  uint32_t bytes = 0;
};

/// Writes a store sequentially. Add the blocks level by level, the finest level first, each level
/// in raster order (x fastest), and then call finish(). Keeps the directory in memory (12 bytes per
/// block and per chunk), but no chunks.
class StoreWriter {
 public:
  /// `metadata_limit`: the most bytes of metadata that finish() accepts; the header's size depends
  /// on it. Errors: no_cells, volume_too_large, invalid_argument (metadata_limit above
  /// 16 KiB). The sink must outlive the writer. field_bytes: field_sections_bytes() of what
  /// finish() will get.
  static Result<StoreWriter> create(Index3 voxels, size_t metadata_limit, ByteSink& sink,
                                    size_t field_bytes = 0);

  StoreWriter(StoreWriter&&) noexcept;
  StoreWriter& operator=(StoreWriter&&) noexcept;
  ~StoreWriter();

  /// Adds the next block. `bytes`: its chunks, concatenated. `interval`: that of the block's cells.
  /// `bands` is empty if no cell of the block can be active.
  /// Errors: invalid_argument (the bands do not tile the interval, or there are too many blocks),
  /// volume_too_large (a chunk above 16 MiB), io_error.
  Result<void> add_block(CellInterval interval, std::span<const BandChunk> bands,
                         std::span<const std::byte> bytes);

  /// Writes the directory and the header, after every block was added. Reads grid, mapping, range,
  /// missing_voxels, metadata and field from `info`; sets the other members and returns the result.
  /// Errors: invalid_argument (blocks are missing, or the metadata is too long), io_error.
  Result<StoreInfo> finish(const StoreInfo& info);

  /// Bytes written to the sink so far, including the header.
  uint64_t bytes_written() const;

 private:
  struct State;
  explicit StoreWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
