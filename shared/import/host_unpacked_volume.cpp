#include <fmt/format.h>

#include "shared/import/unpacked_volume.h"
#include "shared/import/volume/opened_volume.h"

// In WebAssembly, JavaScript unpacks files before it opens them (web/import/unpack_file.ts).
namespace isosplat::import {

Result<OpenVolume> open_unpacked(const std::filesystem::path& path, Packing packing,
                                 const UnpackedOpener&) {
  return fail(Status::unsupported_format,
              fmt::format("{}: expected an unpacked file, found {}-compressed data: unpack "
                          "it with {} -d",
                          path.string(), name_of(packing), name_of(packing)));
}

}  // namespace isosplat::import
