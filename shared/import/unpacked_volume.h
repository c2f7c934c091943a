#pragma once

#include <functional>

#include "shared/import/codecs/packing.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// The functions that open an unpacked file.
struct UnpackedOpener {
  /// Checks the beginning of a volume in the file at a path. The rest is unpacked only if this
  /// succeeds.
  std::function<Result<void>(const std::filesystem::path&)> check;
  std::function<Result<OpenVolume>(const std::filesystem::path&)> open;
};

/// Opens a file that is compressed as a whole. It is decompressed to a file in the system's folder
/// for temporary files, which is removed with the volume, and when the program ends. Messages and
/// VolumeSource::files name the compressed file. In WebAssembly the caller of open_volume
/// decompresses files, and this function returns an error. Errors: those of `opener` and of
/// UnpackStream; io_error if the folder has too little space.
Result<OpenVolume> open_unpacked(const std::filesystem::path& path, Packing packing,
                                 const UnpackedOpener& opener);

}  // namespace isosplat::import
