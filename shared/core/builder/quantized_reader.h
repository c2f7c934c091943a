#pragma once

#include <functional>
#include <span>
#include <vector>

#include "shared/core/builder/executor.h"
#include "shared/core/grid/volume_source.h"
#include "shared/core/preprocess/quantization.h"

namespace isosplat {

/// Size of the buffer for voxels before quantization to `bits` bits, at least one slice. 0 if
/// voxels and quantized values have the same size: then the quantization is in place.
uint64_t staging_bytes(const VolumeHeader& header, uint8_t bits);

/// Reads slices of a source as quantized values.
class QuantizedReader {
 public:
  /// Called once per slice, on any of the threads, with its quantized values.
  using Visit =
      std::function<void(unsigned thread, const std::byte* quantized_values, size_t voxels)>;

  /// The source, the quantization and the executor must outlive the reader.
  QuantizedReader(VolumeSource& source, const Quantization& quantization, Executor& executor);

  /// Bytes of a slice of quantized values.
  size_t slice_bytes() const { return voxels_per_slice_ * quantization_.mapping().bits / 8; }

  /// Reads the slices [first, first + count) to `to`, slice_bytes() each, and calls `visit` for
  /// each. Errors: those of the source.
  Result<void> read(int32_t first, int32_t count, std::byte* to, const Visit& visit);

 private:
  VolumeSource& source_;
  const Quantization& quantization_;
  Executor& executor_;
  const size_t voxels_per_slice_;
  std::vector<std::byte> staging_;
};

}  // namespace isosplat
