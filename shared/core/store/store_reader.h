#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/sampling/cell.h"

namespace isosplat {

/// A store's header always ends within this many bytes of the file's start: one read opens a store.
inline constexpr size_t kMaxStoreHeaderBytes = 64 * 1024;

/// The size of the levels in bootstrap_range(). With the largest header and further pages that is
/// 144 KiB until the first surface; the coarsest level alone may take more.
inline constexpr uint64_t kBootstrapBytes = 64 * 1024;

/// A field: a second scalar at the voxels of a store's volume.
struct FieldInfo {
  std::string name;  ///< of at most 64 letters, digits, '_', '-' and '.'; begins with a letter
  ValueMapping mapping;
  CellInterval range;           ///< of all its voxels that have a value, as quantized values
  uint64_t missing_voxels = 0;  ///< voxels where it has no value
};

/// A field of a store, and where its bytes lie in the store (StoreKind::field).
struct FieldRef {
  FieldInfo info;
  uint64_t offset = 0;
  uint64_t bytes = 0;
};

/// What bytes in the form of a store hold. A field has the grid, mapping, blocks, pages and bands
/// of its store, so that the same quantized isovalues select them. Its chunks are field chunks
/// (ChunkDecoder::decode_field).
enum class StoreKind : uint8_t { store, field };

/// Description of a store and its volume.
struct StoreInfo {
  VolumeGrid grid;
  ValueMapping mapping;
  CellInterval range;   ///< of all voxels that have a value, as quantized values
  uint32_t levels = 0;  ///< level_count(grid.voxels)
  uint64_t chunk_count = 0;
  uint64_t missing_voxels = 0;  ///< voxels without a value
  uint64_t file_bytes = 0;
  uint32_t header_bytes = 0;             ///< length of the header; the chunks follow
  std::array<uint8_t, 16> content_id{};  ///< hash of all content: equal for equal stores only
  std::string metadata;  ///< JSON text for people and viewers: name, histogram, … (FORMAT.md)
  std::vector<FieldRef> fields;    ///< of the store
  std::optional<FieldInfo> field;  ///< only of a field: what its chunks hold
};

/// The part of the file that belongs to one level. The file holds the chunks of the levels, finest
/// level first, and then the pages, coarsest level first. So the chunks and pages of the coarse
/// levels are contiguous.
struct LevelRef {
  LevelGrid grid;
  CellInterval interval;  ///< of all its cells
  uint64_t chunks_offset = 0;
  uint64_t chunks_bytes = 0;
  uint64_t chunk_count = 0;
  uint32_t first_page = 0;  ///< its pages are pages()[first_page, first_page + page_count)
  uint32_t page_count = 0;
};

/// The byte range that holds all chunks and pages of the levels ≥ first_level.
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

/// A block, as its page describes it. A block has no band if none of its cells can be active.
struct BlockRef {
  BlockKey key;
  CellInterval interval;  ///< of all its cells
  uint32_t band_count = 0;
};

/// A valid directory page that was not added yet: see StoreReader::parse_page.
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

/// Finds the chunks of a store for isovalues and blocks, from the header and the directory pages
/// that were added. It does no input: the caller supplies the bytes of a file or of HTTP responses.
/// Bytes are untrusted: everything is validated before it is used. Keeps copies, not references.
class StoreReader {
 public:
  /// `header`: the file's first min(kMaxStoreHeaderBytes, file size) bytes; further bytes are
  /// ignored.
  /// Errors: not_a_store, unsupported_version, truncated, checksum_mismatch, malformed_header.
  /// Bytes of another kind than the expected one are refused: not_a_store, or malformed_header
  /// where a field was expected.
  static Result<StoreReader> open(std::span<const std::byte> header,
                                  StoreKind kind = StoreKind::store);

  StoreReader(StoreReader&&) noexcept;
  StoreReader& operator=(StoreReader&&) noexcept;
  ~StoreReader();

  /// Replaces the distances between voxels, for a volume whose file stated none: the header of the
  /// store is unchanged. Call it before anything reads info().
  /// Errors: invalid_argument unless all three are finite and above 0.
  Result<void> set_spacing(const Vec3d& spacing);

  const StoreInfo& info() const;

  /// info().levels entries.
  std::span<const LevelRef> levels() const;

  /// The byte range of the coarse tail: as many of the coarsest levels as fit in max_bytes with
  /// their pages, but at least the coarsest level.
  CoarseRange coarse_range(uint64_t max_bytes) const;

  /// The byte range that a viewer reads after the header: the coarse tail within max_bytes, and the
  /// pages of finer levels that follow it, up to 5/4 of max_bytes in all, or 256 bytes of pages.
  /// These levels then need no further round trip for their pages.
  CoarseRange bootstrap_range(uint64_t max_bytes = kBootstrapBytes) const;

  std::span<const PageRef> pages() const;
  bool is_resident(uint32_t page) const;

  /// The number of the page that describes a block. Errors: not_found (no such block).
  Result<uint32_t> page_of(BlockKey block) const;

  /// Adds pages()[page], given its bytes. A page may be added repeatedly.
  /// Errors: not_found, truncated, checksum_mismatch, malformed_page.
  Result<void> add_page(uint32_t page, std::span<const std::byte> bytes);

  /// The same in two steps, for readers that several threads share. `parse_page` is safe to call at
  /// any time. `add_page` and `remove_page` change which pages are resident, and need exclusive
  /// access. The results of page_of, info, levels and pages never change.
  Result<ParsedPage> parse_page(uint32_t page, std::span<const std::byte> bytes) const;
  void add_page(ParsedPage&& page);
  void remove_page(uint32_t page);

  /// Errors: not_found, page_not_resident.
  Result<BlockRef> block(BlockKey key) const;

  /// A chunk, given its block and band. Errors: not_found, page_not_resident.
  Result<ChunkRef> chunk(BlockKey block, uint32_t band) const;

  /// The chunk that holds every cell of the block that is active for `quantized_isovalue`; nothing
  /// if no cell is. Errors: not_found, page_not_resident.
  Result<std::optional<ChunkRef>> chunk_for(BlockKey block, float quantized_isovalue) const;

  /// Every chunk of a level whose band overlaps [low, high] (quantized isovalues), page by page.
  /// Fails with page_not_resident if a page whose interval overlaps the range is missing;
  /// `missing_pages` lists these pages.
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
