#pragma once

#include <optional>
#include <vector>

#include "shared/core/builder/executor.h"
#include "shared/core/builder/quantized_reader.h"
#include "shared/core/preprocess/layer.h"
#include "shared/core/preprocess/statistics.h"

namespace isosplat {

/// The slices of a level that the layer `z` of its blocks needs, with those before it
/// (kVoxelsBefore).
LevelBox layer_voxels(const LevelGrid& grid, int32_t z);

/// Reads layers of blocks of level 0 as quantized values, and counts these.
class LayerReader {
 public:
  /// The source, the quantization and the executor must outlive the reader.
  LayerReader(VolumeSource& source, const Quantization& quantization, Executor& executor);

  /// Reads the slices layer_voxels(…, z), and returns them. They are valid until the next call.
  /// Slices that the layer before has in common with it are not read again if that layer was the
  /// last one. counts_values: whether the values of the layer's own slices are counted; each slice
  /// belongs to one layer. Errors: those of the source.
  Result<const std::byte*> read(int32_t z, bool counts_values);

  /// Adds the counts to `statistics`, and begins to count anew.
  void take_values(VolumeStatistics& statistics);

  /// Frees the memory of the layer.
  void release();

 private:
  /// Reads slices to their position in the buffer, which begins with the slice `buffer_first`.
  Result<void> read_slices(int32_t buffer_first, int32_t first, int32_t end, bool counts_values);

  const LevelGrid grid_;
  const ValueMapping mapping_;
  QuantizedReader reader_;
  std::vector<VolumeStatistics> values_;  // per thread of the executor
  std::vector<std::byte> buffer_;         // a layer's slices, and the slices before it
  int32_t buffered_z_ = -1;               // the layer of the buffer; −1: none
};

}  // namespace isosplat
