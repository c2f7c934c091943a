#include "shared/core/store/directory_page.h"

#include "shared/core/store/byte_order.h"
#include "shared/core/store/checksum.h"
#include "shared/core/store/format.h"

namespace isosplat {
namespace {

constexpr const char* kRemedy = ": rebuild the store, or fetch it again";

std::string name_of(const PageRef& page) {
  return "page from block " + block_name({page.level, page.first_block});
}

bool is_within(CellInterval inner, CellInterval outer) {
  return outer.min <= inner.min && inner.max <= outer.max;
}

tl::unexpected<Error> malformed(const PageRef& page, const std::string& what) {
  return fail(Status::malformed_page, name_of(page) + ": " + what + kRemedy);
}

/// Reads the records of blocks and chunks. Checks only that their numbers match the page's size.
Result<DirectoryPage> read_records(std::span<const std::byte> bytes, const PageRef& page) {
  const Index3 box = page.end_block - page.first_block;
  const auto block_count = static_cast<size_t>(box.x * box.y * box.z);  // at most 32³
  if (bytes.size() < kPageHeaderBytes) return malformed(page, "it is too short for its own header");
  FieldReader field(bytes.data());
  const uint32_t blocks_found = field.u32();
  const size_t chunk_count = field.u32();
  if (blocks_found != block_count) {
    return malformed(page, "expected " + std::to_string(block_count) + " blocks, found " +
                               std::to_string(blocks_found));
  }
  const size_t block_end = kPageHeaderBytes + block_count * kBlockRecordBytes;
  if (bytes.size() < block_end || (bytes.size() - block_end) % kChunkRecordBytes != 0 ||
      (bytes.size() - block_end) / kChunkRecordBytes != chunk_count) {
    return malformed(page, std::to_string(chunk_count) + " chunks do not fill its " +
                               std::to_string(bytes.size()) + " bytes");
  }
  DirectoryPage result;
  result.blocks.resize(block_count);
  result.chunks.resize(chunk_count);
  uint64_t first_chunk = 0;
  for (auto& block : result.blocks) {
    block.offset = field.u48();
    block.interval = {field.u16(), field.u16()};
    block.band_count = field.u16();
    block.first_chunk = static_cast<uint32_t>(first_chunk);
    first_chunk += block.band_count;
  }
  if (first_chunk != chunk_count) {
    return malformed(page, "its blocks have " + std::to_string(first_chunk) +
                               " bands, but it has " + std::to_string(chunk_count) + " chunks");
  }
  for (auto& chunk : result.chunks) {
    chunk.checksum = field.u32();
    chunk.bytes = field.u24();
    chunk.cells = field.u24();
    chunk.band_end = field.u16();
  }
  return result;
}

/// Checks a block's interval, bands and place in the file. `chunks_end`: the end of the chunks of
/// the blocks before; returns that of this block's.
Result<void> check_block(const DirectoryPage& directory, const DirectoryPage::Block& block,
                         Index3 index, const PageRef& page, const LevelRef& level,
                         uint64_t& chunks_end) {
  const auto invalid = [&](const std::string& what) {
    return malformed(page, "block " + block_name({page.level, index}) + what);
  };
  if (block.band_count == 0) {
    if (block.interval.min != block.interval.max || block.offset != 0) {
      return invalid(" has cells, but no band");
    }
    return {};
  }
  if (block.interval.min >= block.interval.max || !is_within(block.interval, page.interval)) {
    return invalid(": its interval is empty, or not within that of the page");
  }
  if (block.offset < chunks_end) return invalid(": its chunks overlap those before");
  uint64_t end = block.offset;
  const Index3 size = block_cells(level.grid, index);
  const auto max_cells = static_cast<uint32_t>(size.x * size.y * size.z);
  uint32_t band_begin = block.interval.min;
  for (uint32_t band = 0; band < block.band_count; ++band) {
    const auto& chunk = directory.chunks[block.first_chunk + band];
    if (chunk.band_end <= band_begin) {
      return invalid(": band " + std::to_string(band) + " ends at " +
                     std::to_string(chunk.band_end) + ", which is not after its begin, " +
                     std::to_string(band_begin));
    }
    band_begin = chunk.band_end;
    if (chunk.cells > max_cells || (chunk.cells == 0) != (chunk.bytes == 0)) {
      return invalid(": band " + std::to_string(band) + " announces " +
                     std::to_string(chunk.cells) + " cells in " + std::to_string(chunk.bytes) +
                     " bytes");
    }
    end += chunk.bytes;
  }
  if (band_begin != block.interval.max) {
    return invalid(": expected its bands to end at " + std::to_string(block.interval.max) +
                   ", found " + std::to_string(band_begin));
  }
  if (end > level.chunks_offset + level.chunks_bytes) {
    return invalid(": its chunks lie outside its level's");
  }
  chunks_end = end;
  return {};
}

}  // namespace

Result<DirectoryPage> parse_page(std::span<const std::byte> bytes, const PageRef& page,
                                 const LevelRef& level) {
  if (bytes.size() < page.bytes) {
    return fail(Status::truncated, name_of(page) + ": expected " + std::to_string(page.bytes) +
                                       " bytes, found " + std::to_string(bytes.size()) + kRemedy);
  }
  bytes = bytes.first(page.bytes);
  if (checksum32(bytes) != page.checksum) {
    return fail(Status::checksum_mismatch,
                name_of(page) + ": its checksum differs from the recorded one" + kRemedy);
  }
  Result<DirectoryPage> result = read_records(bytes, page);
  if (!result) return result;
  uint64_t chunks_end = level.chunks_offset;
  const Index3 box = page.end_block - page.first_block;
  for (size_t i = 0; i < result->blocks.size(); ++i) {
    const auto n = static_cast<int32_t>(i);
    const Index3 index = page.first_block + Index3{n % box.x, n / box.x % box.y, n / box.x / box.y};
    const auto checked = check_block(*result, result->blocks[i], index, page, level, chunks_end);
    if (!checked) return tl::unexpected(checked.error());
  }
  return result;
}

std::vector<std::byte> write_page(const DirectoryPage& page) {
  std::vector<std::byte> out;
  out.reserve(kPageHeaderBytes + page.blocks.size() * kBlockRecordBytes +
              page.chunks.size() * kChunkRecordBytes);
  FieldWriter to(out);
  to.field(4, page.blocks.size());
  to.field(4, page.chunks.size());
  for (const auto& block : page.blocks) {
    to.field(6, block.offset);
    to.field(2, block.interval.min);
    to.field(2, block.interval.max);
    to.field(2, block.band_count);
  }
  for (const auto& chunk : page.chunks) {
    to.field(4, chunk.checksum);
    to.field(3, chunk.bytes);
    to.field(3, chunk.cells);
    to.field(2, chunk.band_end);
  }
  return out;
}

}  // namespace isosplat
