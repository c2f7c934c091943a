#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import {

/// The lines of an NRRD header.
struct NrrdHeader {
  std::map<std::string, std::string> fields;  ///< names in lower case, without spaces
  bool has_segments = false;                  ///< key/value pairs of 3D Slicer describe segments
  uint64_t data_offset = 0;  ///< offset of the first byte after the header in its file

  /// The text after the field's colon; empty if the field is absent. Fields with two names
  /// ("centers", "centerings") are stored under the first.
  std::string_view field(std::string_view name) const {
    const auto found = fields.find(std::string(name));
    return found == fields.end() ? std::string_view{} : std::string_view(found->second);
  }
};

/// Reads the header of a file. Errors: io_error, malformed_volume.
Result<NrrdHeader> read_nrrd_header(const std::filesystem::path& path);

/// Adds notes about fields that are not in the specification, which may be misspelt, and about
/// values that were quantized before they were stored.
void note_unused_fields(const NrrdHeader& header, std::vector<std::string>& notes);

/// The error for an invalid header. `what`: what was expected and found.
tl::unexpected<Error> malformed_nrrd(const std::filesystem::path& path, const std::string& what);

/// The voxel type for the field "type". Nothing for "block" and unknown types.
std::optional<VoxelType> nrrd_type(std::string_view text);

/// The strings in double quotes of a field such as "space units". Nothing if a quote is missing.
std::optional<std::vector<std::string>> quoted_strings(std::string_view text);

/// Parses "(1,0,0)". Nothing if the text is not a vector.
std::optional<std::vector<double>> parse_vector(std::string_view text);

/// Splits "space directions" or "space origin" into vectors and "none"s. White space is allowed
/// inside parentheses.
std::vector<std::string> split_vectors(std::string_view text);

}  // namespace isosplat::import
