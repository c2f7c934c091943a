#pragma once

#include <functional>

#include "shared/import/codecs/packing.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// What opens an unpacked file.
struct UnpackedOpener {
  /// Whether the beginning of a volume is in the file at a path: only then is all of it unpacked.
  std::function<Result<void>(const std::filesystem::path&)> check;
  std::function<Result<OpenVolume>(const std::filesystem::path&)> open;
};

/// Opens a file that is compressed as a whole: it is decompressed to a file of the system's folder
/// for temporary files, which is removed with the volume, and when the program ends. Messages and
/// VolumeSource::files name the compressed file. In WebAssembly the caller of open_volume unpacks
/// files, and this is an error. Errors: those of `opener` and of UnpackStream; io_error if the
/// folder has not enough space.
Result<OpenVolume> open_unpacked(const std::filesystem::path& path, Packing packing,
                                 const UnpackedOpener& opener);

}  // namespace isosplat::import
