#pragma once

#include <memory>
#include <span>
#include <vector>

#include "shared/store/store_reader.h"

namespace isosplat {

/// Where a store's bytes go: a file, or memory. Offsets come in ascending order and without gaps
/// from header_bytes on; the header is written last, at offset 0.
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
  uint32_t band_end = 0;  ///< it begins where the one before ends; the first at the block's min
  uint32_t cells = 0;
  uint32_t bytes = 0;
};

/// Writes a store front to back: blocks level by level, finest first, each level in raster order
/// (x fastest), then finish(). Holds the directory (12 bytes per block and per chunk), not the
/// chunks.
class StoreWriter {
 public:
  /// `metadata_limit`: bytes that the metadata given to finish() may have at most; the header is
  /// sized by it. Errors: no_cells, volume_too_large, invalid_argument (metadata_limit above
  /// 16 KiB). The sink must outlive the writer.
  static Result<StoreWriter> create(Index3 voxels, size_t metadata_limit, ByteSink& sink);

  StoreWriter(StoreWriter&&) noexcept;
  StoreWriter& operator=(StoreWriter&&) noexcept;
  ~StoreWriter();

  /// The next block, whose chunks' bytes are one after the other in `bytes`. `interval` is that of
  /// the block's cells; where `bands` is empty, no cell of the block is ever active.
  /// Errors: invalid_argument (bands do not tile the interval, more blocks than there are,
  /// volume_too_large (a chunk above 16 MiB), io_error.
  Result<void> add_block(CellInterval interval, std::span<const BandChunk> bands,
                         std::span<const std::byte> bytes);

  /// What remains to be said of the volume once every block is there. `info` brings grid, mapping,
  /// range, missing_voxels and metadata; the rest is filled in and returned.
  /// Errors: invalid_argument (blocks are missing, the metadata is too long), io_error.
  Result<StoreInfo> finish(const StoreInfo& info);

  /// Bytes handed to the sink so far, with the header.
  uint64_t bytes_written() const;

  /// Bytes of the chunks of a level that has been written, or of its part so far.
  uint64_t level_bytes(uint32_t level) const;

 private:
  struct State;
  explicit StoreWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
