#include "shared/core/store/store_writer.h"

#include <algorithm>

#include "shared/core/store/checksum.h"
#include "shared/core/store/directory_page.h"
#include "shared/core/store/format.h"
#include "shared/core/store/store_header.h"

namespace isosplat {

Result<void> MemorySink::write(uint64_t offset, std::span<const std::byte> data) {
  const auto at = static_cast<size_t>(offset);
  if (bytes.size() < at + data.size()) bytes.resize(at + data.size());
  std::copy(data.begin(), data.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  return {};
}

struct StoreWriter::State {
  ByteSink* sink = nullptr;
  StoreHeader header;
  ContentHash content;  ///< of everything after the header
  uint64_t offset = 0;  ///< where the next bytes go
  uint32_t level = 0;   ///< of the next block
  uint64_t next_block = 0;
  std::vector<DirectoryPage> levels;  ///< per level: all its blocks as one page

  Result<void> append(std::span<const std::byte> bytes) {
    if (bytes.empty()) return {};
    if (auto written = sink->write(offset, bytes); !written) return written;
    content.add(bytes);
    offset += bytes.size();
    return {};
  }

  /// The part of a level's directory that one page holds.
  DirectoryPage cut_page(const PageRef& ref) const {
    const DirectoryPage& all = levels[ref.level];
    const Index3 blocks = header.levels[ref.level].grid.blocks;
    DirectoryPage page;
    for (int32_t z = ref.first_block.z; z < ref.end_block.z; ++z) {
      for (int32_t y = ref.first_block.y; y < ref.end_block.y; ++y) {
        for (int32_t x = ref.first_block.x; x < ref.end_block.x; ++x) {
          const auto n =
              (static_cast<size_t>(z) * static_cast<size_t>(blocks.y) + static_cast<size_t>(y)) *
                  static_cast<size_t>(blocks.x) +
              static_cast<size_t>(x);
          const auto& block = all.blocks[n];
          page.blocks.push_back(block);
          const auto first = all.chunks.begin() + block.first_chunk;
          page.chunks.insert(page.chunks.end(), first, first + block.band_count);
        }
      }
    }
    return page;
  }
};

StoreWriter::StoreWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
StoreWriter::StoreWriter(StoreWriter&&) noexcept = default;
StoreWriter& StoreWriter::operator=(StoreWriter&&) noexcept = default;
StoreWriter::~StoreWriter() = default;

Result<StoreWriter> StoreWriter::create(Index3 voxels, size_t metadata_limit, ByteSink& sink,
                                        size_t field_bytes) {
  const auto page_log2 = choose_page_log2(voxels);
  if (!page_log2) return tl::unexpected(page_log2.error());
  if (metadata_limit > kMaxMetadataBytes) {
    return fail(Status::invalid_argument, "metadata: expected at most " +
                                              std::to_string(kMaxMetadataBytes) + " bytes, found " +
                                              std::to_string(metadata_limit));
  }
  auto state = std::make_unique<State>();
  state->sink = &sink;
  StoreHeader& header = state->header;
  header.page_log2 = *page_log2;
  header.info.header_bytes =
      static_cast<uint32_t>(header_bytes_for(voxels, *page_log2, metadata_limit) + field_bytes);
  header.pages = list_pages(voxels, *page_log2);
  header.info.levels = level_count(voxels);
  for (uint32_t l = 0; l < header.info.levels; ++l) {
    LevelRef level;
    level.grid = level_grid(voxels, l);
    for (uint32_t i = 0; i < header.pages.size(); ++i) {
      if (header.pages[i].level != l) continue;
      if (level.page_count++ == 0) level.first_page = i;
    }
    header.levels.push_back(level);
  }
  state->levels.resize(header.info.levels);
  state->offset = header.info.header_bytes;
  header.levels[0].chunks_offset = state->offset;
  return StoreWriter(std::move(state));
}

uint64_t StoreWriter::bytes_written() const {
  return state_->offset;
}

Result<void> StoreWriter::add_block(CellInterval interval, std::span<const BandChunk> bands,
                                    std::span<const std::byte> bytes) {
  State& state = *state_;
  const auto invalid = [&](const char* what) {
    return fail(Status::invalid_argument, "block number " + std::to_string(state.next_block) +
                                              " of level " + std::to_string(state.level) + ": " +
                                              what);
  };
  if (state.level >= state.header.info.levels) return invalid("there are no more blocks");
  LevelRef& level = state.header.levels[state.level];
  DirectoryPage& directory = state.levels[state.level];

  DirectoryPage::Block block{};
  if (!bands.empty()) {
    block = {state.offset, interval, static_cast<uint32_t>(directory.chunks.size()),
             static_cast<uint32_t>(bands.size())};
    uint32_t begin = interval.min;
    size_t at = 0;
    for (const BandChunk& band : bands) {
      if (band.band_end <= begin || band.band_end > interval.max) {
        return invalid("its bands do not ascend within its interval");
      }
      begin = band.band_end;
      if ((band.cells == 0) != (band.bytes == 0) || bytes.size() - at < band.bytes) {
        return invalid("the sizes of its chunks do not match their bytes");
      }
      if (band.bytes > kMaxChunkBytes) {
        return fail(Status::volume_too_large, "a chunk has " + std::to_string(band.bytes) +
                                                  " bytes, more than the format can hold");
      }
      directory.chunks.push_back({checksum32(bytes.subspan(at, band.bytes)), band.bytes, band.cells,
                                  static_cast<uint16_t>(band.band_end)});
      at += band.bytes;
      level.chunk_count += band.cells > 0;
    }
    if (begin != interval.max || at != bytes.size()) {
      return invalid("its bands do not end with its interval, or its chunks not with its bytes");
    }
    if (auto appended = state.append(bytes); !appended) return appended;
    level.chunks_bytes += bytes.size();
    if (level.interval.min == level.interval.max) level.interval = interval;
    level.interval.min = std::min(level.interval.min, interval.min);
    level.interval.max = std::max(level.interval.max, interval.max);
  }
  directory.blocks.push_back(block);

  if (++state.next_block == level.grid.block_count()) {
    state.next_block = 0;
    if (++state.level < state.header.info.levels) {
      state.header.levels[state.level].chunks_offset = state.offset;
    }
  }
  return {};
}

Result<StoreInfo> StoreWriter::finish(const StoreInfo& info) {
  State& state = *state_;
  StoreHeader& header = state.header;
  if (state.level != header.info.levels) {
    return fail(Status::invalid_argument,
                "blocks of level " + std::to_string(state.level) + " are missing");
  }
  for (PageRef& ref : header.pages) {
    const DirectoryPage page = state.cut_page(ref);
    ref.interval = {};
    for (const auto& block : page.blocks) {
      if (block.band_count == 0) continue;
      if (ref.interval.min == ref.interval.max) ref.interval = block.interval;
      ref.interval.min = std::min(ref.interval.min, block.interval.min);
      ref.interval.max = std::max(ref.interval.max, block.interval.max);
    }
    const std::vector<std::byte> bytes = write_page(page);
    ref.offset = state.offset;
    ref.bytes = static_cast<uint32_t>(bytes.size());
    ref.checksum = checksum32(bytes);
    if (auto appended = state.append(bytes); !appended) return tl::unexpected(appended.error());
  }
  const uint32_t header_bytes = header.info.header_bytes;
  header.info = info;
  header.info.header_bytes = header_bytes;
  header.info.levels = static_cast<uint32_t>(header.levels.size());
  header.info.chunk_count = 0;
  for (const LevelRef& level : header.levels) header.info.chunk_count += level.chunk_count;
  header.info.file_bytes = state.offset;
  header.info.content_id = {};
  auto bytes = write_store_header(header);
  if (!bytes) return tl::unexpected(bytes.error());
  state.content.add(std::span(*bytes).first(header_bytes - kHeaderChecksumBytes));
  header.info.content_id = state.content.digest();
  bytes = write_store_header(header);
  if (auto written = state.sink->write(0, *bytes); !written) {
    return tl::unexpected(written.error());
  }
  return header.info;
}

}  // namespace isosplat
