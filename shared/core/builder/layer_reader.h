#pragma once

#include <optional>
#include <vector>

#include "shared/core/builder/executor.h"
#include "shared/core/builder/quantized_reader.h"
#include "shared/core/preprocess/layer.h"
#include "shared/core/preprocess/statistics.h"

namespace isosplat {

/// The voxels of a level that a band of the layer `z` of its blocks needs, with those before it
/// (kVoxelsBefore): all along x.
LevelBox band_voxels(const LevelGrid& grid, int32_t z, BlockRows band);

/// Reads layers of blocks of level 0 as quantized values, or bands of layers, and counts these.
class LayerReader {
 public:
  /// The source, the quantization and the executor must outlive the reader.
  LayerReader(VolumeSource& source, const Quantization& quantization, Executor& executor);

  /// Reads band_voxels(…, z, band), and returns them. They are valid until the next call. Slices
  /// that a whole layer has in common with the one before it are not read again if that layer was
  /// the last one. counted: whose values are counted; each voxel belongs to one row of blocks.
  /// Errors: those of the source.
  Result<const std::byte*> read(int32_t z, BlockRows band, BlockRows counted);

  /// Adds the counts to `statistics`, and begins to count anew.
  void take_values(VolumeStatistics& statistics);

  /// Frees the buffer.
  void release();

 private:
  const LevelGrid grid_;
  const ValueMapping mapping_;
  QuantizedReader reader_;
  std::vector<VolumeStatistics> values_;  // per thread of the executor
  std::vector<std::byte> buffer_;         // of a band, with the voxels before it
  int32_t buffered_z_ = -1;               // the whole layer in the buffer; −1: none
};

}  // namespace isosplat
