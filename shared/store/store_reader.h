#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/base/status.h"
#include "shared/sampling/cell.h"

namespace isosplat {

/// A store's header always ends within this many bytes of the file's start: one read opens a store.
inline constexpr size_t kMaxStoreHeaderBytes = 64 * 1024;

/// Sizes of bootstrap_range(). With the largest header that is 144 KiB until the first surface; the
/// coarsest level alone may take more.
inline constexpr uint64_t kBootstrapBytes = 64 * 1024;
inline constexpr uint64_t kBootstrapBytesWithPages = 80 * 1024;

/// What a store says of its volume.
struct StoreInfo {
  VolumeGrid grid;
  ValueMapping mapping;
  CellInterval range;   ///< of all voxels that have a value, as quantized values
  uint32_t levels = 0;  ///< level_count(grid.voxels)
  uint64_t chunk_count = 0;
  uint64_t missing_voxels = 0;  ///< voxels without a value
  uint64_t file_bytes = 0;
  uint32_t header_bytes = 0;             ///< where the header ends; the chunks follow
  std::array<uint8_t, 16> content_id{};  ///< hash of all content: two stores with it are the same
  std::string metadata;  ///< JSON text for people and pages: name, histogram, … (FORMAT.md)
};

/// One level's part of the file. The chunks of the levels follow each other, finest first, and are
/// followed by the pages, coarsest level first: the coarse levels' chunks and pages lie together.
struct LevelRef {
  LevelGrid grid;
  CellInterval interval;  ///< of all its cells
  uint64_t chunks_offset = 0;
  uint64_t chunks_bytes = 0;
  uint64_t chunk_count = 0;
  uint32_t first_page = 0;  ///< its pages are pages()[first_page, first_page + page_count)
  uint32_t page_count = 0;
};

/// Everything of the levels from first_level on, chunks and pages, as one run of bytes.
struct CoarseRange {
  uint32_t first_level = 0;
  uint64_t offset = 0;
  uint64_t bytes = 0;
};

struct DirectoryPage;

/// A chunk: the cells of one block that are active for some quantized isovalue in [band_begin,
/// band_end).
struct ChunkRef {
  BlockKey block;
  uint32_t band = 0;  ///< index within the block, ascending by isovalue
  QuantizedValue band_begin = 0;
  uint32_t band_end = 0;  ///< up to 65535
  uint64_t offset = 0;    ///< in the file
  uint32_t bytes = 0;
  uint32_t cells = 0;     ///< that it decodes to; 0 only where bytes is 0 (a gap between values)
  uint32_t checksum = 0;  ///< low 32 bits of XXH3-64 of its bytes
};

/// A directory page: a box of blocks of one level. The header lists all of them, coarsest level
/// first.
struct PageRef {
  uint32_t level = 0;
  Index3 first_block;     ///< the box of blocks that it describes,
  Index3 end_block;       ///< half-open
  CellInterval interval;  ///< of all cells of these blocks: no isovalue outside needs the page
  uint64_t offset = 0;    ///< in the file
  uint32_t bytes = 0;
  uint32_t checksum = 0;  ///< low 32 bits of XXH3-64 of its bytes
};

/// A block, as its page describes it. Blocks without a single cell that can be active have no band.
struct BlockRef {
  BlockKey key;
  CellInterval interval;  ///< of all its cells
  uint32_t band_count = 0;
};

/// A directory page that was accepted, and is not resident yet: see StoreReader::parse_page.
class ParsedPage {
 public:
  ParsedPage(ParsedPage&&) noexcept;
  ParsedPage& operator=(ParsedPage&&) noexcept;
  ~ParsedPage();

 private:
  friend class StoreReader;
  ParsedPage(uint32_t index, std::unique_ptr<DirectoryPage> page);
  uint32_t index_;
  std::unique_ptr<DirectoryPage> page_;
};

/// Answers "which chunks" from a store's header and the pages added so far. It reads nothing
/// itself: the caller brings the bytes, from a file, a socket or a fetch. All bytes are taken as
/// hostile; what has been accepted is consistent. Copies what it keeps.
class StoreReader {
 public:
  /// `header`: the file's first min(kMaxStoreHeaderBytes, file size) bytes; more is ignored.
  /// Errors: not_a_store, unsupported_version, truncated, checksum_mismatch, malformed_header.
  static Result<StoreReader> open(std::span<const std::byte> header);

  StoreReader(StoreReader&&) noexcept;
  StoreReader& operator=(StoreReader&&) noexcept;
  ~StoreReader();

  const StoreInfo& info() const;

  /// info().levels entries.
  std::span<const LevelRef> levels() const;

  /// The coarse tail of the file: as many of the coarsest levels as fit in max_bytes with their
  /// pages, at least the coarsest one. One read of it makes these levels complete.
  CoarseRange coarse_range(uint64_t max_bytes) const;

  /// What a viewer reads first, after the header: the coarse tail within kBootstrapBytes, and of
  /// the pages of finer levels behind it those that end within kBootstrapBytesWithPages of its
  /// begin, so that these levels need no round trip of their own.
  CoarseRange bootstrap_range() const;

  std::span<const PageRef> pages() const;
  bool is_resident(uint32_t page) const;

  /// The page that describes a block. The block must exist (invalid blocks: not_found).
  Result<uint32_t> page_of(BlockKey block) const;

  /// Adds the bytes of pages()[page]. Adding a page again is harmless.
  /// Errors: not_found, truncated, checksum_mismatch, malformed_page.
  Result<void> add_page(uint32_t page, std::span<const std::byte> bytes);

  /// The same in two steps, for readers that several threads share: `parse_page` may be called by
  /// any of them at a time; `add_page` (harmless to repeat) and `remove_page` change what is
  /// resident. Of an opened store, page_of, info, levels and pages never change.
  Result<ParsedPage> parse_page(uint32_t page, std::span<const std::byte> bytes) const;
  void add_page(ParsedPage&& page);
  void remove_page(uint32_t page);

  /// Errors: not_found, page_not_resident.
  Result<BlockRef> block(BlockKey key) const;

  /// The chunk by its place. Errors: not_found, page_not_resident.
  Result<ChunkRef> chunk(BlockKey block, uint32_t band) const;

  /// The one chunk that holds every cell of the block that is active for `quantized_isovalue`;
  /// nothing where none is. Errors: not_found, page_not_resident.
  Result<std::optional<ChunkRef>> chunk_for(BlockKey block, float quantized_isovalue) const;

  /// Every chunk of a level whose band meets [low, high] (quantized isovalues), page by page. Fails
  /// with page_not_resident when a page whose interval meets the range is missing; `missing_pages`
  /// names them.
  Result<std::vector<ChunkRef>> chunks_for(uint32_t level, float low, float high) const;
  std::vector<uint32_t> missing_pages(uint32_t level, float low, float high) const;

  /// The same for one block, bands ascending. Errors: not_found, page_not_resident.
  Result<std::vector<ChunkRef>> chunks_for(BlockKey block, float low, float high) const;

 private:
  struct State;
  explicit StoreReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
