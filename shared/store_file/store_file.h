#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <shared_mutex>
#include <span>
#include <string>
#include <vector>

#include "shared/base/status.h"
#include "shared/posix_file/posix_file.h"
#include "shared/store/store_reader.h"

namespace isosplat {

/// Names a chunk.
struct ChunkAddress {
  BlockKey block;
  uint32_t band = 0;
};

/// What one query for chunks may select, and what it may look through to find it.
struct ChunkBudget {
  uint64_t bytes = UINT64_MAX;
  uint64_t chunks = UINT64_MAX;
  uint64_t directory_bytes = UINT64_MAX;  ///< of the pages that hold the blocks
};

/// Where over_budget, the sums are of what was met until then.
struct ChunkSelection {
  std::vector<ChunkRef> chunks;
  uint64_t bytes = 0;            ///< of all chunks
  uint64_t count = 0;            ///< of all chunks
  uint64_t directory_bytes = 0;  ///< of the pages, each time that a block lies in another one
  bool over_budget = false;      ///< `chunks` is empty: the budget does not suffice
};

/// A store on disk behind StoreReader: opens it, reads the header, loads directory pages when they
/// are needed, and reads chunks. All functions may be called from any thread at a time.
///
/// It keeps the file open, so a store that was replaced (by rename) goes on to be read whole by
/// those who hold it. A file changed in place is refused: every read checks.
class StoreFile {
 public:
  /// `directory_bytes`: of the pages kept at a time, as they are in the file, and the last one
  /// whatever its size; beyond it those that no query has used for longest are dropped.
  /// Errors: those of StoreReader::open, truncated (the file is shorter than its header says), and
  /// io_error. Messages begin with the path.
  static Result<std::shared_ptr<StoreFile>> open(const std::filesystem::path& path,
                                                 uint64_t directory_bytes = uint64_t{256} << 20);
  StoreFile(const StoreFile&) = delete;
  StoreFile& operator=(const StoreFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const StoreInfo& info() const { return info_; }
  const FileIdentity& identity() const { return identity_; }

  /// info().content_id in lower-case hexadecimal, 32 digits.
  const std::string& content() const { return content_; }

  std::span<const PageRef> pages() const { return pages_; }

  /// What a viewer reads first, after the header (StoreReader::bootstrap_range).
  const CoarseRange& bootstrap() const { return bootstrap_; }

  /// The bytes of the header, for StoreReader::open.
  std::span<const std::byte> header() const { return header_; }

  /// The bytes of a page, its checksum compared. Errors: not_found, io_error, truncated,
  /// checksum_mismatch.
  Result<std::vector<std::byte>> read_page(uint32_t page) const;

  /// As StoreReader's functions of these names; pages are loaded as needed. Errors: theirs but
  /// page_not_resident, and those of read_page.
  Result<BlockRef> block(BlockKey key) const;
  Result<ChunkRef> chunk(BlockKey block, uint32_t band) const;
  Result<std::optional<ChunkRef>> chunk_for(BlockKey block, float quantized_isovalue) const;

  /// Every chunk of a level whose band meets [low, high] (quantized isovalues), in file order.
  /// Stops when the budget is exceeded, so that the work is bounded by it.
  Result<ChunkSelection> chunks_for(uint32_t level, float low, float high,
                                    const ChunkBudget& budget = {}) const;

  /// The same for the blocks named, in that order, bands ascending. Errors also: not_found.
  Result<ChunkSelection> chunks_for(std::span<const BlockKey> blocks, float low, float high,
                                    const ChunkBudget& budget = {}) const;

  /// The chunks named, in that order. Errors: those of chunk().
  Result<ChunkSelection> chunks_at(std::span<const ChunkAddress> addresses,
                                   const ChunkBudget& budget) const;

  /// Appends the chunk's bytes, checked against its checksum; nothing on failure. Errors: io_error,
  /// truncated, checksum_mismatch.
  Result<void> read_chunk(const ChunkRef& chunk, std::vector<std::byte>& out) const;

  /// Fills `out` with the file's bytes at `offset`, unchecked. Errors: io_error, truncated.
  Result<void> read(uint64_t offset, std::span<std::byte> out) const;

  /// Whether the file that is held open was written to since it was opened. Errors: io_error.
  Result<void> check_unchanged() const;

 private:
  StoreFile(std::filesystem::path path, PosixFile file, FileIdentity identity,
            std::vector<std::byte> header, StoreReader reader, uint64_t directory_bytes);

  Error at(Error error) const;

  /// The page of a block, without its bytes. Errors: not_found.
  Result<uint32_t> page_of(BlockKey block) const;

  /// A page's bytes, unchecked.
  Result<std::vector<std::byte>> load_page(uint32_t page) const;

  /// Calls `look_up` with the reader once it has the page; queries that find theirs there run side
  /// by side.
  template <class LookUp>
  auto with_page(uint32_t page, LookUp look_up) const
      -> decltype(look_up(std::declval<const StoreReader&>()));

  std::filesystem::path path_;
  PosixFile file_;
  FileIdentity identity_;
  std::vector<std::byte> header_;
  StoreInfo info_;
  std::vector<PageRef> pages_;
  CoarseRange bootstrap_;
  std::string content_;
  uint64_t directory_bytes_;

  /// Drops pages until so many more bytes fit. The caller holds mutex_ alone.
  void make_room(uint64_t bytes) const;

  mutable std::shared_mutex mutex_;
  mutable StoreReader reader_;           // guarded by mutex_; its header never changes
  mutable uint64_t resident_bytes_ = 0;  // guarded by mutex_
  mutable std::atomic<uint64_t> uses_ = 0;
  mutable std::vector<std::atomic<uint64_t>> last_use_;  // of each page, by uses_
};

}  // namespace isosplat
