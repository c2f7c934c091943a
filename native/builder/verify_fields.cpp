#include "native/builder/verify_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "native/builder/parallel.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/store/checksum.h"
#include "shared/core/store/format.h"
#include "shared/system/store_file/field_file.h"

namespace isosplat {
namespace {

constexpr uint64_t kPieceBytes = uint64_t{4} << 20;
constexpr const char* kRemedy = ": rebuild the store, or fetch it again";

/// Compares a field chunk with what the store's chunk needs. next: where the field's next chunk
/// begins.
bool is_same_band(const ChunkRef& of_store, const ChunkRef& of_field, uint64_t next) {
  return of_store.band_begin == of_field.band_begin && of_store.band_end == of_field.band_end &&
         of_store.cells == of_field.cells && of_field.offset == next;
}

/// Decodes the field chunks of blocks, and compares their values. One object per thread.
class FieldChecker {
 public:
  FieldChecker(const StoreFile& store, const StoreFile& field) : store_(store), field_(field) {}

  /// `begin`: where the chunks of the block begin in the field. Returns where they end.
  Result<uint64_t> check(const BlockRef& block, uint64_t begin, bool decodes) {
    const LevelGrid grid = level_grid(store_.info().grid.voxels, block.key.level);
    const Index3 cells = block_cells(grid, block.key.index);
    lattice_.assign(
        decodes ? static_cast<size_t>((cells.x + 1) * (cells.y + 1) * (cells.z + 1)) : 0, kUnknown);
    for (uint32_t band = 0; band < block.band_count; ++band) {
      const auto chunk = store_.chunk(block.key, band);
      if (!chunk) return tl::unexpected(chunk.error());
      const auto of_field = field_.chunk(block.key, band);
      if (!of_field) return tl::unexpected(of_field.error());
      if (!is_same_band(*chunk, *of_field, begin)) return differs(*chunk, "its band or its place");
      begin += of_field->bytes;
      if (!decodes || chunk->cells == 0) continue;
      if (auto checked = check_chunk(*chunk, *of_field, cells); !checked) {
        return tl::unexpected(checked.error());
      }
    }
    return begin;
  }

 private:
  static constexpr int32_t kUnknown = -1;

  Result<void> check_chunk(const ChunkRef& chunk, const ChunkRef& of_field, Index3 cells) {
    bytes_.clear();
    if (auto read = store_.read_chunk(chunk, bytes_); !read) return read;
    const ChunkShape shape{cells, chunk.band_begin, chunk.band_end, chunk.cells,
                           chunk.block.level > 0};
    if (auto decoded = decoder_.decode(bytes_, shape, cells_); !decoded) return decoded;
    bytes_.clear();
    if (auto read = field_.read_chunk(of_field, bytes_); !read) return read;
    const FieldInfo& info = *field_.info().field;
    auto decoded =
        decoder_.decode_field(bytes_, cells, cells_.cell, 1u << info.mapping.bits, corners_);
    if (!decoded) return fail(decoded.error().status, name_of(chunk) + decoded.error().message);
    for (size_t i = 0; i < corners_.size(); ++i) {
      const uint32_t cell = cells_.cell[i];
      for (uint32_t c = 0; c < 8; ++c) {
        const QuantizedValue value = corners_[i][c];
        const bool is_missing = info.mapping.has_missing && value == kMissingVoxel;
        if (!is_missing && (value < info.range.min || value > info.range.max)) {
          return differs(chunk, "a value outside its range");
        }
        const auto x = static_cast<int32_t>((cell & 63) + (c & 1));
        const auto y = static_cast<int32_t>((cell >> 6 & 63) + (c >> 1 & 1));
        const auto z = static_cast<int32_t>((cell >> 12) + (c >> 2));
        int32_t& known = lattice_[static_cast<size_t>((z * (cells.y + 1) + y) * (cells.x + 1) + x)];
        if (known != kUnknown && known != value) return differs(chunk, "a value of another band");
        known = value;
      }
    }
    return {};
  }

  std::string name_of(const ChunkRef& chunk) const {
    return fmt::format("field '{}', chunk {}: ", field_.info().field->name,
                       chunk_name(chunk.block, chunk.band));
  }

  tl::unexpected<Error> differs(const ChunkRef& chunk, const char* what) const {
    return fail(Status::malformed_chunk, name_of(chunk) + "expected what the store has, found " +
                                             what + " to differ" + kRemedy);
  }

  const StoreFile &store_, &field_;
  std::vector<std::byte> bytes_;
  ChunkDecoder decoder_;
  DecodedCells cells_;
  std::vector<CellCorners> corners_;
  std::vector<int32_t> lattice_;
};

/// Checks that the chunks of a level follow each other, and appends where those of each block
/// begin.
Result<void> check_level(const StoreFile& store, FieldChecker& checker, const LevelRef& of_field,
                         std::vector<BlockRef>& blocks, std::vector<uint64_t>& begins) {
  uint64_t at = of_field.chunks_offset;
  const Index3 n = of_field.grid.blocks;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        const auto block = store.block({of_field.grid.level, {x, y, z}});
        if (!block) return tl::unexpected(block.error());
        const auto end = checker.check(*block, at, false);
        if (!end) return tl::unexpected(end.error());
        blocks.push_back(*block);
        begins.push_back(at);
        at = *end;
      }
    }
  }
  if (at == of_field.chunks_offset + of_field.chunks_bytes) return {};
  return fail(Status::malformed_header,
              fmt::format("a field: the chunks of level {} do not fill its bytes{}",
                          of_field.grid.level, kRemedy));
}

Result<uint64_t> verify_field(const StoreFile& store, size_t number, unsigned threads) {
  const auto field = open_field(store, number);
  if (!field) return tl::unexpected(field.error());
  const StoreInfo& info = (*field)->info();
  if (auto checked = verify_content((*field)->file(), info); !checked) {
    return tl::unexpected(checked.error());
  }
  const auto reader = StoreReader::open((*field)->header(), StoreKind::field);
  std::vector<FieldChecker> checkers;
  for (unsigned t = 0; t < threads; ++t) checkers.emplace_back(store, **field);
  std::vector<BlockRef> blocks;
  std::vector<uint64_t> begins;
  for (const LevelRef& level : reader->levels()) {
    auto checked = check_level(store, checkers[0], level, blocks, begins);
    if (!checked) return tl::unexpected(checked.error());
  }
  std::mutex mutex;
  Result<void> result;
  parallel_for(threads, blocks.size(), [&](unsigned thread, size_t i) {
    const auto checked = checkers[thread].check(blocks[i], begins[i], true);
    if (checked) return;
    const std::lock_guard lock(mutex);
    if (result) result = tl::unexpected(checked.error());
  });
  if (!result) return tl::unexpected(result.error());
  return info.chunk_count;
}

}  // namespace

Result<uint64_t> verify_fields(const StoreFile& store, const VerifyOptions& options) {
  const unsigned threads =
      options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  uint64_t chunks = 0;
  for (size_t i = 0; i < store.info().fields.size(); ++i) {
    const auto verified = verify_field(store, i, threads);
    if (!verified) return verified;
    chunks += *verified;
  }
  return chunks;
}

Result<void> verify_content(const FileParts& file, const StoreInfo& info) {
  ContentHash hash;
  std::vector<std::byte> buffer;
  for (uint64_t at = info.header_bytes; at < info.file_bytes; at += buffer.size()) {
    buffer.resize(std::min(kPieceBytes, info.file_bytes - at));
    if (auto read = file.read(at, buffer); !read) return read;
    hash.add(buffer);
  }
  std::vector<std::byte> header(info.header_bytes);
  if (auto read = file.read(0, header); !read) return read;
  std::fill_n(header.begin() + kContentIdOffset, 16, std::byte{0});
  hash.add(std::span(header).first(header.size() - kHeaderChecksumBytes));
  if (hash.digest() == info.content_id) return {};
  return fail(
      Status::checksum_mismatch,
      fmt::format("the hash of the file differs from the content id in its header{}", kRemedy));
}

}  // namespace isosplat
