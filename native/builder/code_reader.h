#pragma once

#include <functional>
#include <span>
#include <vector>

#include "native/import/volume_source.h"
#include "shared/preprocess/value_codes.h"

namespace isosplat {

/// Bytes of voxels that are read from the source at a time before they become codes of so many
/// bits, at least one slice. 0 where voxels are of the size of codes and are read in place.
size_t staging_bytes(const VolumeHeader& header, uint8_t bits);

/// Reads slices of a source as codes.
class CodeReader {
 public:
  /// Called on one of the threads with the codes of a slice.
  using Visit = std::function<void(unsigned thread, const std::byte* codes, size_t voxels)>;

  /// Borrows the source and the codes.
  CodeReader(VolumeSource& source, const ValueCodes& codes, unsigned threads);

  /// Bytes of a slice of codes.
  size_t slice_bytes() const { return voxels_per_slice_ * codes_.mapping().bits / 8; }

  /// Slices [first, first + count) to `to`, each of slice_bytes(); `visit` sees each once. Errors:
  /// those of the source.
  Result<void> read(int32_t first, int32_t count, std::byte* to, const Visit& visit);

 private:
  VolumeSource& source_;
  const ValueCodes& codes_;
  const unsigned threads_;
  const size_t voxels_per_slice_;
  std::vector<std::byte> staging_;
};

}  // namespace isosplat
