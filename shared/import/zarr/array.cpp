#include "shared/import/zarr/array.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "shared/import/bytes/readable_file.h"
#include "shared/import/zarr/decode.h"

namespace isosplat::import::zarr {
namespace {

namespace fs = std::filesystem;

/// The files of more chunks are not counted before they are read.
constexpr size_t kMaxCounted = 200'000;
constexpr uint64_t kMaxIndexBytes = uint64_t{64} << 20;

/// Compressed data are at most this much larger than the elements.
constexpr uint64_t most_stored(uint64_t bytes) {
  return bytes + bytes / 8 + 4096;
}

uint64_t little_endian(std::span<const std::byte> bytes) {
  uint64_t number = 0;
  for (size_t i = 8; i-- > 0;) number = number << 8 | static_cast<uint64_t>(bytes[i]);
  return number;
}

class ZarrArray : public ChunkedReader {
 public:
  ZarrArray(const Node& node, const ArrayPart& part)
      : ChunkedReader(node.folder.string(), node.array->grid, part),
        folder_(node.folder),
        array_(*node.array) {}

  /// The chunks of the part, and how many of them have no file. Of shards, those that are absent as
  /// a whole.
  std::pair<size_t, size_t> count_absent() const {
    size_t all = 0, absent = 0;
    for (const uint64_t number : numbers()) {
      ++all;
      absent += input_kind(file_of(place_of(number))) != InputKind::file;
    }
    return {all, absent};
  }

  std::vector<fs::path> files() const override { return metadata_files(folder_); }

  uint64_t resident_bytes() const override {
    return ChunkedReader::resident_bytes() + index_.size();
  }

 private:
  Result<std::vector<std::byte>> decode(uint64_t number, bool /*is_at_edge*/) override {
    const std::vector<uint64_t> place = place_of(number);
    const fs::path path = file_of(place);
    const InputKind kind = input_kind(path);
    if (kind == InputKind::none) return std::vector<std::byte>{};
    const auto bytes = static_cast<size_t>(grid().chunk_bytes());
    std::vector<std::byte> stored;
    if (!array_.shards) {
      const auto file = ReadableFile::open(path);
      if (!file) return tl::unexpected(file.error());
      if (file->size > most_stored(bytes)) return too_large(path, bytes, file->size);
      stored.resize(static_cast<size_t>(file->size));
      if (auto read = read_bytes(*file, 0, stored); !read) return tl::unexpected(read.error());
    } else {
      auto read = read_from_shard(path, place, bytes);
      if (!read) return tl::unexpected(read.error());
      if (read->empty()) return std::move(*read);
      stored = std::move(*read);
    }
    return decode_chunk(array_.codecs, std::move(stored), bytes, path.string());
  }

  static tl::unexpected<Error> too_large(const fs::path& path, uint64_t bytes, uint64_t found) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected a chunk of at most {} bytes, found {}", path.string(),
                            most_stored(bytes), found));
  }

  static Result<void> read_bytes(const ReadableFile& file, uint64_t offset,
                                 std::span<std::byte> out) {
    const auto got = file.input->read_some(offset, out);
    if (!got) return tl::unexpected(got.error());
    if (*got != out.size())
      return file.ends_early(offset + out.size(), offset + *got, "of a chunk");
    return {};
  }

  /// The indices of a chunk along the axes.
  std::vector<uint64_t> place_of(uint64_t number) const {
    std::vector<uint64_t> place(grid().sizes.size());
    for (size_t i = place.size(); i-- > 0;) {
      place[i] = number % grid().chunks_along(i);
      number /= grid().chunks_along(i);
    }
    return place;
  }

  /// The number of chunks of a shard along an axis.
  uint64_t in_shard(size_t axis) const {
    return array_.shards ? array_.shards->shape[axis] / grid().chunk[axis] : 1;
  }

  /// The file of a chunk, or of the shard that it is in.
  fs::path file_of(const std::vector<uint64_t>& place) const {
    std::string key = array_.key_prefix;
    for (size_t i = 0; i < place.size(); ++i) {
      if (!key.empty()) key += array_.separator;
      key += std::to_string(place[i] / in_shard(i));
    }
    return folder_ / key;
  }

  /// Empty if the shard does not have the chunk.
  Result<std::vector<std::byte>> read_from_shard(const fs::path& path,
                                                 const std::vector<uint64_t>& place,
                                                 uint64_t bytes) {
    const auto file = ReadableFile::open(path);
    if (!file) return tl::unexpected(file.error());
    if (path != index_path_) {
      auto index = read_index(*file);
      if (!index) return tl::unexpected(index.error());
      index_ = std::move(*index);
      index_path_ = path;
    }
    uint64_t entry = 0;
    for (size_t i = 0; i < place.size(); ++i) entry = entry * in_shard(i) + place[i] % in_shard(i);
    const auto at = std::span<const std::byte>(index_).subspan(static_cast<size_t>(16 * entry), 16);
    const uint64_t offset = little_endian(at), size = little_endian(at.subspan(8));
    if (offset == ~uint64_t{0} && size == ~uint64_t{0}) return std::vector<std::byte>{};
    if (size > most_stored(bytes)) return too_large(path, bytes, size);
    if (offset > file->size || size > file->size - offset) {
      return fail(Status::truncated,
                  fmt::format("{}: expected {} bytes of a chunk from byte {} on, found {} bytes in "
                              "all: the file is incomplete",
                              path.string(), size, offset, file->size));
    }
    std::vector<std::byte> stored(static_cast<size_t>(size));
    if (auto read = read_bytes(*file, offset, stored); !read) return tl::unexpected(read.error());
    return stored;
  }

  /// For each chunk of a shard its offset and its size, 8 bytes each.
  Result<std::vector<std::byte>> read_index(const ReadableFile& file) const {
    uint64_t bytes = 16;
    for (size_t i = 0; i < grid().chunk.size(); ++i) {
      if (__builtin_mul_overflow(bytes, in_shard(i), &bytes) || bytes > kMaxIndexBytes) {
        return fail(Status::unsupported_format,
                    fmt::format("{}: expected an index of a shard of at most {} MiB, found a "
                                "larger one",
                                file.path.string(), kMaxIndexBytes >> 20));
      }
    }
    const Shards& shards = *array_.shards;
    const uint64_t stored_bytes = bytes + 4 * shards.index_codecs.size();
    if (file.size < stored_bytes) {
      return fail(Status::truncated,
                  fmt::format("{}: expected an index of {} bytes, found {} bytes in all: the file "
                              "is incomplete",
                              file.path.string(), stored_bytes, file.size));
    }
    std::vector<std::byte> stored(static_cast<size_t>(stored_bytes));
    const uint64_t offset = shards.is_index_first ? 0 : file.size - stored_bytes;
    if (auto read = read_bytes(file, offset, stored); !read) return tl::unexpected(read.error());
    return decode_chunk(shards.index_codecs, std::move(stored), static_cast<size_t>(bytes),
                        file.path.string());
  }

  fs::path folder_;
  ArrayMetadata array_;
  fs::path index_path_;  ///< of the shard that was read last
  std::vector<std::byte> index_;
};

}  // namespace

std::unique_ptr<ByteReader> open_array(const Node& node, const ArrayPart& part,
                                       std::vector<std::string>& notes) {
  auto array = std::make_unique<ZarrArray>(node, part);
  uint64_t chunks = 1;
  for (size_t i = 0; i < part.axes.size(); ++i) {
    chunks *= std::min<uint64_t>(node.array->grid.chunks_along(part.axes[i]), kMaxCounted + 1);
    if (chunks > kMaxCounted) return array;
  }
  if (const auto [all, absent] = array->count_absent(); absent > 0) {
    notes.push_back(
        fmt::format("{} of {} chunks are absent: their voxels have the fill value", absent, all));
  }
  return array;
}

}  // namespace isosplat::import::zarr
