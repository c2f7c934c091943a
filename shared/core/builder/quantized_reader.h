#pragma once

#include <functional>
#include <span>
#include <vector>

#include "shared/core/builder/executor.h"
#include "shared/core/grid/volume_source.h"
#include "shared/core/preprocess/quantization.h"

namespace isosplat {

/// Size of the buffer for voxels before quantization to `bits` bits. At least a slice, or a row of
/// sources that read rows. 0 if voxels and quantized values have the same size: then the
/// quantization is in place.
uint64_t staging_bytes(const VolumeHeader& header, uint8_t bits, bool reads_rows);

/// Reads slices of a source, or some of their rows, as quantized values.
class QuantizedReader {
 public:
  /// Called for each slice that was read, or for some of its rows, on any of the threads, with the
  /// quantized values. The part has one slice.
  using Visit = std::function<void(unsigned thread, const SliceRows& part,
                                   const std::byte* quantized_values)>;

  /// The source, the quantization and the executor must outlive the reader.
  QuantizedReader(VolumeSource& source, const Quantization& quantization, Executor& executor);

  /// Bytes of a row of quantized values.
  size_t row_bytes() const { return static_cast<size_t>(n_.x) * quantization_.mapping().bits / 8; }

  /// Reads a part of the volume to `to`: row_bytes() for each row, the rows of each slice behind
  /// those of the slice before. Calls `visit` for all of it. Errors: those of the source.
  Result<void> read(const SliceRows& part, std::byte* to, const Visit& visit);

 private:
  /// Reads what fits in the staging buffer.
  Result<void> read_piece(const SliceRows& part, std::byte* to, const Visit& visit);

  VolumeSource& source_;
  const Quantization& quantization_;
  Executor& executor_;
  const Index3 n_;
  std::vector<std::byte> staging_;
};

}  // namespace isosplat
