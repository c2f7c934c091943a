#pragma once

#include <optional>
#include <vector>

#include "shared/core/builder/block_encoder.h"
#include "shared/core/preprocess/size_budget.h"

namespace isosplat {

/// Receives the encoded blocks of a layer in any order, and passes them to the writer in raster
/// order. From the sizes of the written blocks it computes the size limits of the next ones.
class LayerOutput {
 public:
  /// For the blocks (x, y, z) of a level, numbered in raster order. The limits of block i depend on
  /// exactly the first i + 1 − max_in_flight blocks. So they do not depend on the number of
  /// threads. is_limited: whether blocks have size limits.
  LayerOutput(StoreWriter& writer, SizeBudget& budget, const BandOptions& options,
              const LevelGrid& grid, int32_t z, size_t max_in_flight, bool is_limited);

  /// How many blocks the layer has.
  size_t count() const { return ready_.size(); }

  /// Allows blocks with numbers below `end` to begin: at first none. Does not change limits.
  void open_until(size_t end) { end_ = end; }

  /// Whether the encoding of every block below `end` was begun.
  bool is_begun() const { return begun_ == end_; }
  /// Whether every block below `end` was added.
  bool is_complete() const { return written_ == end_; }

  /// The next block to encode. None if all below `end` were begun, or if earlier blocks must be
  /// added first.
  std::optional<BlockTask> begin_block();

  /// Adds an encoded block. Errors: those of StoreWriter::add_block.
  Result<void> add(size_t number, EncodedBlock&& encoded);

 private:
  StoreWriter& writer_;
  SizeBudget& budget_;
  const BandOptions& options_;
  const LevelGrid grid_;
  const int32_t z_;
  const size_t max_in_flight_;
  const bool is_limited_;
  std::vector<std::optional<EncodedBlock>> ready_;
  std::vector<SizeBudget::Grant> grants_;  // [i]: the grant after i blocks were written
  size_t begun_ = 0, written_ = 0, end_ = 0;

  Index3 index_of(size_t number) const;
};

}  // namespace isosplat
