#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/voxels/chunked_reader.h"
#include "shared/import/voxels/stored_voxels.h"

// The metadata of a Zarr hierarchy: version 2 (.zarray, .zgroup, .zattrs) and version 3
// (zarr.json), as in their specifications (zarr-specs.readthedocs.io). Bytes of strangers:
// everything is checked before it is used.
namespace isosplat::import::zarr {

using Json = nlohmann::json;

/// A codec between the elements of a chunk and its bytes.
struct Codec {
  enum class Kind : uint8_t { gzip, zlib, zstd, lz4, blosc, crc32c, shuffle };
  Kind kind = Kind::gzip;
  uint64_t element_bytes = 1;  ///< of shuffle
};

/// Chunks that are stored together in one file, with an index of their places.
struct Shards {
  std::vector<uint64_t> shape;      ///< elements of a shard along each axis: multiples of a chunk's
  std::vector<Codec> index_codecs;  ///< crc32c, or none
  bool is_index_first = false;
};

struct ArrayMetadata {
  ChunkGrid grid;
  StoredVoxels stored;
  std::vector<Codec> codecs;  ///< in the order of writing
  std::optional<Shards> shards;
  std::string key_prefix;                    ///< of the names of chunks: "c" or empty
  char separator = '/';                      ///< between the indices in the names of chunks
  std::vector<std::string> dimension_names;  ///< empty, or one for each axis
};

/// An array or a group.
struct Node {
  std::filesystem::path folder;
  Json attributes = Json::object();
  std::optional<ArrayMetadata> array;  ///< nothing: a group
};

/// Whether a folder is an array or a group.
bool is_node(const std::filesystem::path& folder);

/// The files with the metadata of a node, those that exist.
std::vector<std::filesystem::path> metadata_files(const std::filesystem::path& folder);

/// The array or group in a folder. Errors: io_error, malformed_volume, unsupported_format (a
/// codec), unsupported_type.
Result<Node> read_node(const std::filesystem::path& folder);

/// A member of an object; null if there is none, or the value is no object.
const Json& member(const Json& json, const char* key);

/// A member that is a text; else empty.
std::string string_of(const Json& json, const char* key);

/// A value of the metadata for a message, shortened.
std::string text_of(const Json& value);

}  // namespace isosplat::import::zarr
