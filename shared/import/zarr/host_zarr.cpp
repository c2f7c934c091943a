#include <fmt/format.h>

#include "shared/import/bytes/input_files.h"
#include "shared/import/zarr/zarr.h"

namespace isosplat::import {

bool is_zarr(const std::filesystem::path& folder) {
  for (const char* name : {"zarr.json", ".zarray", ".zgroup"}) {
    if (input_kind(folder / name) == InputKind::file) return true;
  }
  return false;
}

Result<OpenVolume> open_zarr(const std::filesystem::path& folder,
                             const ImportOptions& /*options*/) {
  return fail(Status::unsupported_format,
              fmt::format("{}: expected a folder with slices, found a Zarr hierarchy, which "
                          "is not read here: build the store with isosplat build",
                          folder.string()));
}

}  // namespace isosplat::import
