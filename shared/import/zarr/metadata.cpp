#include "shared/import/zarr/metadata.h"

#include <fmt/format.h>

#include <numeric>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/text/commands.h"
#include "shared/import/zarr/elements.h"

namespace isosplat::import::zarr {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxMetadataBytes = size_t{16} << 20;
constexpr size_t kMaxAxes = 16;
constexpr uint64_t kMaxSize = uint64_t{1} << 40;
constexpr uint64_t kMaxChunkBytes = uint64_t{256} << 20;

/// The errors of one node.
struct Errors {
  fs::path folder;

  tl::unexpected<Error> malformed(const std::string& what) const {
    return fail(Status::malformed_volume, fmt::format("{}: {}", folder.string(), what));
  }
  tl::unexpected<Error> unsupported(const std::string& what) const {
    return fail(Status::unsupported_format,
                fmt::format("{}: {}: save the array with other codecs, for example with "
                            "python3 -c \"import sys, zarr; zarr.save_array(sys.argv[2], "
                            "zarr.open(sys.argv[1], mode='r')[:])\" {} {}.zarr",
                            folder.string(), what, shell_word(folder),
                            shell_word(folder.stem().string() + "_copy")));
  }
};

Result<Json> read_json(const fs::path& path) {
  const auto text = read_beginning(path, kMaxMetadataBytes);
  if (!text) return tl::unexpected(text.error());
  Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) {
    return fail(Status::malformed_volume,
                path.string() +
                    ": expected an object of JSON, found something else, or a file of "
                    "more than 16 MiB");
  }
  return json;
}

Result<std::vector<uint64_t>> sizes_of(const Json& json, const char* what, const Errors& errors) {
  std::vector<uint64_t> sizes;
  const bool is_list = json.is_array() && !json.empty() && json.size() <= kMaxAxes;
  for (const Json& each : is_list ? json : Json::array()) {
    if (!each.is_number_unsigned() || each.get<uint64_t>() < 1 || each.get<uint64_t>() > kMaxSize) {
      break;
    }
    sizes.push_back(each.get<uint64_t>());
  }
  if (!is_list || sizes.size() != json.size()) {
    return errors.malformed(fmt::format("expected {} of 1 to {} whole numbers from 1, found {}",
                                        what, kMaxAxes, text_of(json)));
  }
  return sizes;
}

/// A codec by its name in either version; nothing for those that change no bytes.
Result<std::optional<Codec>> codec_of(const std::string& name, const Json& settings,
                                      const Errors& errors) {
  using Kind = Codec::Kind;
  constexpr std::pair<std::string_view, Kind> kCodecs[] = {
      {"gzip", Kind::gzip},      {"zlib", Kind::zlib},   {"zstd", Kind::zstd},
      {"lz4", Kind::lz4},        {"blosc", Kind::blosc}, {"crc32c", Kind::crc32c},
      {"shuffle", Kind::shuffle}};
  std::string_view plain = name;
  if (plain.starts_with("numcodecs.")) plain.remove_prefix(10);
  for (const auto& [known, kind] : kCodecs) {
    if (plain != known) continue;
    Codec codec{kind};
    if (kind == Kind::shuffle) {
      const Json& bytes = member(settings, "elementsize");
      codec.element_bytes = bytes.is_number_unsigned() ? bytes.get<uint64_t>() : 4;
      if (codec.element_bytes < 1 || codec.element_bytes > 16) {
        return errors.malformed("expected elements of 1 to 16 bytes to shuffle, found " +
                                text_of(bytes));
      }
    }
    return codec;
  }
  return errors.unsupported(
      fmt::format("expected chunks without compression, or with gzip, zlib, Zstandard, LZ4, Blosc "
                  "or crc32c, found the codec {}",
                  text_of(name)));
}

Result<void> check(ArrayMetadata& array, const Errors& errors) {
  ChunkGrid& grid = array.grid;
  grid.element_bytes = stored_bytes(array.stored);
  if (grid.chunk.size() != grid.sizes.size()) {
    return errors.malformed(fmt::format("expected chunks with {} axes, as the array has, found {}",
                                        grid.sizes.size(), grid.chunk.size()));
  }
  if (grid.chunk_bytes() > kMaxChunkBytes) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected chunks of at most {} MiB, found larger ones: save the "
                            "array with smaller chunks",
                            errors.folder.string(), kMaxChunkBytes >> 20));
  }
  uint64_t bytes = grid.element_bytes;
  for (const uint64_t size : grid.sizes) {
    if (__builtin_mul_overflow(bytes, size, &bytes)) {
      return errors.malformed("expected a shape of fewer than 2^64 bytes, found a larger one");
    }
  }
  return {};
}

Result<ArrayMetadata> read_array_2(const Json& json, const Errors& errors) {
  ArrayMetadata array;
  auto shape = sizes_of(member(json, "shape"), "a shape", errors);
  if (!shape) return tl::unexpected(shape.error());
  auto chunk = sizes_of(member(json, "chunks"), "chunks", errors);
  if (!chunk) return tl::unexpected(chunk.error());
  const auto stored = type_of(string_of(json, "dtype"), errors.folder);
  if (!stored) return tl::unexpected(stored.error());
  array.stored = *stored;
  array.grid.sizes = std::move(*shape);
  array.grid.chunk = std::move(*chunk);
  if (auto checked = check(array, errors); !checked) return tl::unexpected(checked.error());
  auto fill = fill_of(member(json, "fill_value"), array.stored, errors.folder);
  if (!fill) return tl::unexpected(fill.error());
  array.grid.fill = std::move(*fill);
  if (string_of(json, "order") == "F") {
    array.grid.order.resize(array.grid.sizes.size());
    std::iota(array.grid.order.rbegin(), array.grid.order.rend(), size_t{0});
  }
  const std::string separator = string_of(json, "dimension_separator");
  array.separator = separator == "/" ? '/' : '.';
  std::vector<Json> settings;
  const Json &filters = member(json, "filters"), &compressor = member(json, "compressor");
  if (filters.is_array()) settings.assign(filters.begin(), filters.end());
  if (!compressor.is_null()) settings.push_back(compressor);
  for (const Json& each : settings) {
    const auto codec = codec_of(string_of(each, "id"), each, errors);
    if (!codec) return tl::unexpected(codec.error());
    if (*codec) array.codecs.push_back(**codec);
  }
  return array;
}

/// The codecs of version 3 after the one that writes bytes.
struct CodecChain {
  std::vector<size_t> order;  ///< of transpose; empty: none
  bool is_big_endian = false;
  std::vector<Codec> codecs;
  const Json* sharding = nullptr;  ///< its configuration, if it is in place of the bytes
};

Result<CodecChain> read_chain(const Json& list, size_t rank, const Errors& errors) {
  CodecChain chain;
  if (!list.is_array() || list.empty() || list.size() > 16) {
    return errors.malformed("expected 1 to 16 codecs, found " + text_of(list));
  }
  bool has_bytes = false;
  for (const Json& each : list) {
    const std::string name = string_of(each, "name");
    const Json& settings = member(each, "configuration");
    if (name == "transpose" && !has_bytes && chain.order.empty()) {
      const Json& order = member(settings, "order");
      std::vector<bool> seen(rank);
      for (const Json& axis : order.is_array() ? order : Json::array()) {
        const uint64_t to = axis.is_number_unsigned() ? axis.get<uint64_t>() : rank;
        if (to >= rank || seen[to]) break;
        seen[to] = true;
        chain.order.push_back(to);
      }
      if (chain.order.size() != rank || order.size() != rank) {
        return errors.malformed("expected each axis once in the order of transpose, found " +
                                text_of(order));
      }
    } else if (name == "bytes" && !has_bytes) {
      chain.is_big_endian = string_of(settings, "endian") == "big";
      has_bytes = true;
    } else if (name == "sharding_indexed" && !has_bytes) {
      chain.sharding = &settings;
      has_bytes = true;
    } else {
      const auto codec = codec_of(name, settings, errors);
      if (!codec) return tl::unexpected(codec.error());
      if (!has_bytes) return errors.malformed("expected the codec bytes before " + text_of(name));
      if (*codec) chain.codecs.push_back(**codec);
    }
  }
  if (!has_bytes) return errors.malformed("expected the codec bytes, found " + text_of(list));
  return chain;
}

Result<void> read_shards(const CodecChain& outer, ArrayMetadata& array, const Errors& errors) {
  const Json& settings = *outer.sharding;
  if (!outer.codecs.empty() || !outer.order.empty()) {
    return errors.unsupported("expected shards without further codecs, found some");
  }
  auto inner = sizes_of(member(settings, "chunk_shape"), "chunks of shards", errors);
  if (!inner) return tl::unexpected(inner.error());
  Shards shards;
  shards.shape = std::move(array.grid.chunk);
  array.grid.chunk = std::move(*inner);
  bool is_multiple = shards.shape.size() == array.grid.chunk.size();
  for (size_t i = 0; is_multiple && i < shards.shape.size(); ++i) {
    is_multiple = shards.shape[i] % array.grid.chunk[i] == 0;
  }
  if (!is_multiple) {
    return errors.malformed(fmt::format("expected shards of whole chunks, found [{}] and [{}]",
                                        fmt::join(shards.shape, ", "),
                                        fmt::join(array.grid.chunk, ", ")));
  }
  const auto chain = read_chain(member(settings, "codecs"), shards.shape.size(), errors);
  if (!chain) return tl::unexpected(chain.error());
  const auto index = read_chain(member(settings, "index_codecs"), shards.shape.size() + 1, errors);
  if (!index) return tl::unexpected(index.error());
  if (chain->sharding || index->sharding) {
    return errors.unsupported("expected one level of shards, found more");
  }
  bool is_plain = !index->is_big_endian && index->order.empty();
  for (const Codec& codec : index->codecs) is_plain = is_plain && codec.kind == Codec::Kind::crc32c;
  if (!is_plain) return errors.unsupported("expected an index of shards in plain bytes");
  array.stored.big_endian = chain->is_big_endian;
  array.grid.order = chain->order;
  array.codecs = chain->codecs;
  shards.index_codecs = index->codecs;
  shards.is_index_first = string_of(settings, "index_location") == "start";
  array.shards = std::move(shards);
  return {};
}

Result<ArrayMetadata> read_array_3(const Json& json, const Errors& errors) {
  ArrayMetadata array;
  auto shape = sizes_of(member(json, "shape"), "a shape", errors);
  if (!shape) return tl::unexpected(shape.error());
  const Json& grid = member(json, "chunk_grid");
  if (string_of(grid, "name") != "regular") {
    return errors.unsupported("expected a regular grid of chunks, found " + text_of(grid));
  }
  auto chunk = sizes_of(member(member(grid, "configuration"), "chunk_shape"), "chunks", errors);
  if (!chunk) return tl::unexpected(chunk.error());
  const auto stored = type_of(string_of(json, "data_type"), errors.folder);
  if (!stored) return tl::unexpected(stored.error());
  array.stored = *stored;
  array.grid.sizes = std::move(*shape);
  array.grid.chunk = std::move(*chunk);
  const Json& keys = member(json, "chunk_key_encoding");
  const bool is_default = string_of(keys, "name") != "v2";
  const std::string separator = string_of(member(keys, "configuration"), "separator");
  array.key_prefix = is_default ? "c" : "";
  array.separator = separator.empty() ? (is_default ? '/' : '.') : separator[0];
  if (array.separator != '/' && array.separator != '.') {
    return errors.malformed("expected chunks with names separated by / or ., found " +
                            text_of(separator));
  }
  if (!member(json, "storage_transformers").empty()) {
    return errors.unsupported("expected no storage transformers, found some");
  }
  const auto chain = read_chain(member(json, "codecs"), array.grid.sizes.size(), errors);
  if (!chain) return tl::unexpected(chain.error());
  if (chain->sharding) {
    if (auto read = read_shards(*chain, array, errors); !read) return tl::unexpected(read.error());
  } else {
    array.stored.big_endian = chain->is_big_endian;
    array.grid.order = chain->order;
    array.codecs = chain->codecs;
  }
  if (auto checked = check(array, errors); !checked) return tl::unexpected(checked.error());
  auto fill = fill_of(member(json, "fill_value"), array.stored, errors.folder);
  if (!fill) return tl::unexpected(fill.error());
  array.grid.fill = std::move(*fill);
  const Json& names = member(json, "dimension_names");
  if (names.is_array() && names.size() == array.grid.sizes.size()) {
    for (const Json& name : names) {
      array.dimension_names.push_back(name.is_string() ? name.get<std::string>() : std::string());
    }
  }
  return array;
}

}  // namespace

const Json& member(const Json& json, const char* key) {
  static const Json kNull;
  if (!json.is_object()) return kNull;
  const auto found = json.find(key);
  return found == json.end() ? kNull : *found;
}

std::string string_of(const Json& json, const char* key) {
  const Json& found = member(json, key);
  return found.is_string() ? found.get<std::string>() : std::string();
}

bool is_node(const fs::path& folder) {
  for (const char* name : {"zarr.json", ".zarray", ".zgroup"}) {
    if (input_kind(folder / name) == InputKind::file) return true;
  }
  return false;
}

std::vector<fs::path> metadata_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const char* name : {"zarr.json", ".zarray", ".zgroup", ".zattrs"}) {
    if (input_kind(folder / name) == InputKind::file) files.push_back(folder / name);
  }
  return files;
}

Result<Node> read_node(const fs::path& folder) {
  const Errors errors{folder};
  Node node;
  node.folder = folder;
  if (input_kind(folder / "zarr.json") == InputKind::file) {
    const auto json = read_json(folder / "zarr.json");
    if (!json) return tl::unexpected(json.error());
    if (member(*json, "attributes").is_object()) node.attributes = member(*json, "attributes");
    if (string_of(*json, "node_type") != "array") return node;
    auto array = read_array_3(*json, errors);
    if (!array) return tl::unexpected(array.error());
    node.array = std::move(*array);
    return node;
  }
  if (input_kind(folder / ".zattrs") == InputKind::file) {
    auto attributes = read_json(folder / ".zattrs");
    if (!attributes) return tl::unexpected(attributes.error());
    node.attributes = std::move(*attributes);
  }
  if (input_kind(folder / ".zarray") == InputKind::file) {
    const auto json = read_json(folder / ".zarray");
    if (!json) return tl::unexpected(json.error());
    auto array = read_array_2(*json, errors);
    if (!array) return tl::unexpected(array.error());
    node.array = std::move(*array);
    return node;
  }
  if (input_kind(folder / ".zgroup") == InputKind::file) return node;
  return errors.malformed("expected zarr.json, .zarray or .zgroup, found none of them");
}

std::string text_of(const Json& value) {
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() > 80 ? text.substr(0, 80) + "…" : text;
}

}  // namespace isosplat::import::zarr
