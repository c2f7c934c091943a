#pragma once

#include <functional>
#include <span>
#include <vector>

#include "native/import/volume_source.h"
#include "shared/preprocess/quantization.h"

namespace isosplat {

/// Bytes of voxels that are read from the source at a time before they become quantized values of
/// so many bits, at least one slice. 0 where voxels are of the size of quantized values and are
/// read in place.
size_t staging_bytes(const VolumeHeader& header, uint8_t bits);

/// Reads slices of a source as codes.
class QuantizedReader {
 public:
  /// Called on one of the threads with the quantized values of a slice.
  using Visit =
      std::function<void(unsigned thread, const std::byte* quantized_values, size_t voxels)>;

  /// Borrows the source and the codes.
  QuantizedReader(VolumeSource& source, const Quantization& quantization, unsigned threads);

  /// Bytes of a slice of quantized values.
  size_t slice_bytes() const { return voxels_per_slice_ * quantization_.mapping().bits / 8; }

  /// Slices [first, first + count) to `to`, each of slice_bytes(); `visit` sees each once. Errors:
  /// those of the source.
  Result<void> read(int32_t first, int32_t count, std::byte* to, const Visit& visit);

 private:
  VolumeSource& source_;
  const Quantization& quantization_;
  const unsigned threads_;
  const size_t voxels_per_slice_;
  std::vector<std::byte> staging_;
};

}  // namespace isosplat
