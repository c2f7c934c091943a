#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/import/open_volume.h"

namespace isosplat {

/// A request of JavaScript to open a volume.
struct ImportRequest {
  std::filesystem::path path;
  import::ImportOptions options;
};

/// Parses {"path", "options"}: ImportOptions in web/import/types.ts. Errors: invalid_argument.
Result<ImportRequest> parse_import_request(std::string_view text);

/// An open volume as JSON text: ImportedVolume in web/import/types.ts. `choices`: the volumes that
/// could have been read instead.
std::string imported_text(const std::filesystem::path& path, const import::OpenVolume& volume,
                          const std::vector<import::VolumeChoice>& choices);

/// The volumes of a file as a JSON list: VolumeChoice in web/import/types.ts.
std::string choices_text(const std::vector<import::VolumeChoice>& volumes);

}  // namespace isosplat
