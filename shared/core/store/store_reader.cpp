#include "shared/core/store/store_reader.h"

#include <algorithm>
#include <cmath>

#include "shared/core/store/directory_page.h"
#include "shared/core/store/format.h"
#include "shared/core/store/header_sections.h"
#include "shared/core/store/store_header.h"

namespace isosplat {
namespace {

/// Pages of finer levels that a bootstrap range may have in any case, for stores of small volumes.
constexpr uint64_t kSmallPages = 256;

bool is_inside(Index3 index, Index3 end) {
  return index.x >= 0 && index.y >= 0 && index.z >= 0 && index.x < end.x && index.y < end.y &&
         index.z < end.z;
}

}  // namespace

struct StoreReader::State {
  StoreHeader header;
  std::vector<std::unique_ptr<DirectoryPage>> pages;  ///< null: not resident

  /// A block's record, and the page that holds it.
  struct BlockRecord {
    const DirectoryPage* page;
    const DirectoryPage::Block* block;
  };

  Result<uint32_t> page_of(BlockKey key) const {
    if (key.level >= header.info.levels ||
        !is_inside(key.index, header.levels[key.level].grid.blocks)) {
      return fail(Status::not_found, "block " + block_name(key) + " does not exist");
    }
    const LevelRef& level = header.levels[key.level];
    const Index3 boxes = pages_of_level(level.grid.blocks, header.page_log2);
    const Index3 box{key.index.x >> header.page_log2, key.index.y >> header.page_log2,
                     key.index.z >> header.page_log2};
    return level.first_page + static_cast<uint32_t>((box.z * boxes.y + box.y) * boxes.x + box.x);
  }

  Result<BlockRecord> find(BlockKey key) const {
    const auto number = page_of(key);
    if (!number) return tl::unexpected(number.error());
    const DirectoryPage* page = pages[*number].get();
    if (!page) {
      return fail(Status::page_not_resident,
                  "block " + block_name(key) + ": add page " + std::to_string(*number) + " first");
    }
    const PageRef& ref = header.pages[*number];
    const Index3 at = key.index - ref.first_block, box = ref.end_block - ref.first_block;
    return BlockRecord{page,
                       &page->blocks[static_cast<size_t>((at.z * box.y + at.y) * box.x + at.x)]};
  }

  /// Calls visit(ChunkRef) for the bands of a block, ascending, until it returns false.
  template <class Visit>
  static void visit_bands(const DirectoryPage& page, const DirectoryPage::Block& block,
                          BlockKey key, Visit visit) {
    uint64_t offset = block.offset;
    uint32_t begin = block.interval.min;
    for (uint32_t s = 0; s < block.band_count; ++s) {
      const auto& chunk = page.chunks[block.first_chunk + s];
      if (!visit(ChunkRef{key, s, static_cast<QuantizedValue>(begin), chunk.band_end, offset,
                          chunk.bytes, chunk.cells, chunk.checksum})) {
        return;
      }
      begin = chunk.band_end;
      offset += chunk.bytes;
    }
  }

  /// Appends the chunks of a block whose bands overlap [low, high].
  static void append_chunks(const DirectoryPage& page, const DirectoryPage::Block& block,
                            BlockKey key, float low, float high, std::vector<ChunkRef>& out) {
    if (!is_active_within(block.interval, low, high)) return;
    visit_bands(page, block, key, [&](const ChunkRef& chunk) {
      if (static_cast<float>(chunk.band_begin) > high) return false;
      if (low < static_cast<float>(chunk.band_end) && chunk.cells > 0) out.push_back(chunk);
      return true;
    });
  }
};

StoreReader::StoreReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
StoreReader::StoreReader(StoreReader&&) noexcept = default;
StoreReader& StoreReader::operator=(StoreReader&&) noexcept = default;
StoreReader::~StoreReader() = default;

Result<StoreReader> StoreReader::open(std::span<const std::byte> bytes, StoreKind kind) {
  auto header = parse_store_header(bytes.first(std::min(bytes.size(), kMaxStoreHeaderBytes)));
  if (!header) return tl::unexpected(header.error());
  if (kind == StoreKind::store && header->info.field) {
    return fail(Status::not_a_store,
                "expected a store, found a field of one: open the store that has it");
  }
  if (kind == StoreKind::field && (!header->info.field || !header->info.fields.empty())) {
    return malformed_header("expected a field, found a store");
  }
  auto state = std::make_unique<State>();
  state->header = std::move(*header);
  state->pages.resize(state->header.pages.size());
  return StoreReader(std::move(state));
}

Result<void> StoreReader::set_spacing(const Vec3d& spacing) {
  for (const double length : {spacing.x, spacing.y, spacing.z}) {
    if (!std::isfinite(length) || !(length > 0)) {
      return fail(Status::invalid_argument,
                  "spacing: expected three numbers above 0, found " + std::to_string(length));
    }
  }
  state_->header.info.grid.spacing = spacing;
  return {};
}

const StoreInfo& StoreReader::info() const {
  return state_->header.info;
}

std::span<const LevelRef> StoreReader::levels() const {
  return state_->header.levels;
}

std::span<const PageRef> StoreReader::pages() const {
  return state_->header.pages;
}

CoarseRange StoreReader::coarse_range(uint64_t max_bytes) const {
  const StoreHeader& header = state_->header;
  CoarseRange range;
  for (auto l = static_cast<uint32_t>(header.levels.size()); l-- > 0;) {
    const LevelRef& level = header.levels[l];
    const PageRef& last_page = header.pages[level.first_page + level.page_count - 1];
    const uint64_t bytes = last_page.offset + last_page.bytes - level.chunks_offset;
    if (bytes > max_bytes && l + 1 < header.levels.size()) break;
    range = {l, level.chunks_offset, bytes};
  }
  return range;
}

CoarseRange StoreReader::bootstrap_range(uint64_t max_bytes) const {
  CoarseRange range = coarse_range(max_bytes);
  const uint64_t limit =
      range.offset + std::max(range.bytes + kSmallPages, max_bytes + max_bytes / 4);
  for (const PageRef& page : state_->header.pages) {
    const uint64_t end = page.offset + page.bytes;
    if (end <= limit) range.bytes = std::max(range.bytes, end - range.offset);
  }
  return range;
}

bool StoreReader::is_resident(uint32_t page) const {
  return page < state_->pages.size() && state_->pages[page];
}

Result<uint32_t> StoreReader::page_of(BlockKey block) const {
  return state_->page_of(block);
}

ParsedPage::ParsedPage(uint32_t index, std::unique_ptr<DirectoryPage> page)
    : index_(index), page_(std::move(page)) {}
ParsedPage::ParsedPage(ParsedPage&&) noexcept = default;
ParsedPage& ParsedPage::operator=(ParsedPage&&) noexcept = default;
ParsedPage::~ParsedPage() = default;

Result<ParsedPage> StoreReader::parse_page(uint32_t page, std::span<const std::byte> bytes) const {
  if (page >= state_->pages.size()) {
    return fail(Status::not_found, "page " + std::to_string(page) +
                                       " does not exist: the store has " +
                                       std::to_string(state_->pages.size()));
  }
  const PageRef& ref = state_->header.pages[page];
  auto parsed = isosplat::parse_page(bytes, ref, state_->header.levels[ref.level]);
  if (!parsed) return tl::unexpected(parsed.error());
  return ParsedPage(page, std::make_unique<DirectoryPage>(std::move(*parsed)));
}

void StoreReader::add_page(ParsedPage&& page) {
  state_->pages[page.index_] = std::move(page.page_);
}

Result<void> StoreReader::add_page(uint32_t page, std::span<const std::byte> bytes) {
  auto parsed = parse_page(page, bytes);
  if (!parsed) return tl::unexpected(parsed.error());
  add_page(std::move(*parsed));
  return {};
}

void StoreReader::remove_page(uint32_t page) {
  if (page < state_->pages.size()) state_->pages[page].reset();
}

Result<BlockRef> StoreReader::block(BlockKey key) const {
  const auto record = state_->find(key);
  if (!record) return tl::unexpected(record.error());
  return BlockRef{key, record->block->interval, record->block->band_count};
}

Result<ChunkRef> StoreReader::chunk(BlockKey key, uint32_t band) const {
  const auto record = state_->find(key);
  if (!record) return tl::unexpected(record.error());
  if (band >= record->block->band_count) {
    return fail(Status::not_found, "block " + block_name(key) + " has " +
                                       std::to_string(record->block->band_count) +
                                       " bands, not band " + std::to_string(band));
  }
  ChunkRef found;
  State::visit_bands(*record->page, *record->block, key, [&](const ChunkRef& chunk) {
    found = chunk;
    return chunk.band < band;
  });
  return found;
}

Result<std::optional<ChunkRef>> StoreReader::chunk_for(BlockKey key,
                                                       float quantized_isovalue) const {
  const auto record = state_->find(key);
  if (!record) return tl::unexpected(record.error());
  std::optional<ChunkRef> found;
  if (!is_active(record->block->interval, quantized_isovalue)) return found;
  State::visit_bands(*record->page, *record->block, key, [&](const ChunkRef& chunk) {
    if (quantized_isovalue >= static_cast<float>(chunk.band_end)) return true;
    if (chunk.cells > 0) found = chunk;
    return false;
  });
  return found;
}

Result<std::vector<ChunkRef>> StoreReader::chunks_for(uint32_t level, float low, float high) const {
  const StoreHeader& header = state_->header;
  if (level >= header.info.levels) {
    return fail(Status::not_found, "level " + std::to_string(level) +
                                       " does not exist: the store has " +
                                       std::to_string(header.info.levels));
  }
  std::vector<ChunkRef> found;
  const LevelRef& of_level = header.levels[level];
  for (uint32_t i = of_level.first_page; i < of_level.first_page + of_level.page_count; ++i) {
    const PageRef& ref = header.pages[i];
    if (!is_active_within(ref.interval, low, high)) continue;
    const DirectoryPage* page = state_->pages[i].get();
    if (!page) {
      return fail(Status::page_not_resident, "add page " + std::to_string(i) + " first");
    }
    size_t n = 0;
    for (int32_t z = ref.first_block.z; z < ref.end_block.z; ++z) {
      for (int32_t y = ref.first_block.y; y < ref.end_block.y; ++y) {
        for (int32_t x = ref.first_block.x; x < ref.end_block.x; ++x, ++n) {
          State::append_chunks(*page, page->blocks[n], {level, {x, y, z}}, low, high, found);
        }
      }
    }
  }
  return found;
}

Result<std::vector<ChunkRef>> StoreReader::chunks_for(BlockKey key, float low, float high) const {
  const auto record = state_->find(key);
  if (!record) return tl::unexpected(record.error());
  std::vector<ChunkRef> found;
  State::append_chunks(*record->page, *record->block, key, low, high, found);
  return found;
}

std::vector<uint32_t> StoreReader::missing_pages(uint32_t level, float low, float high) const {
  const StoreHeader& header = state_->header;
  std::vector<uint32_t> missing;
  if (level >= header.info.levels) return missing;
  const LevelRef& of_level = header.levels[level];
  for (uint32_t i = of_level.first_page; i < of_level.first_page + of_level.page_count; ++i) {
    if (!state_->pages[i] && is_active_within(header.pages[i].interval, low, high))
      missing.push_back(i);
  }
  return missing;
}

}  // namespace isosplat
