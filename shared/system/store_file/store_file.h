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

#include "shared/core/base/status.h"
#include "shared/core/store/store_reader.h"
#include "shared/system/posix_file/file_parts.h"

namespace isosplat {

/// Identifies a chunk.
struct ChunkAddress {
  BlockKey block;
  uint32_t band = 0;
};

/// Blocks of a level: the half-open range [first, end) along each axis. By default all.
struct BlockRange {
  Index3 first;
  Index3 end{INT32_MAX, INT32_MAX, INT32_MAX};
};

/// Limits of one query for chunks.
struct ChunkBudget {
  uint64_t bytes = UINT64_MAX;
  uint64_t chunks = UINT64_MAX;
  uint64_t directory_bytes = UINT64_MAX;  ///< of the directory pages that it reads
};

/// The result of a query for chunks. If over_budget, the sums are those at the point where it
/// stopped.
struct ChunkSelection {
  std::vector<ChunkRef> chunks;
  uint64_t bytes = 0;            ///< of all chunks
  uint64_t count = 0;            ///< of all chunks
  uint64_t directory_bytes = 0;  ///< of the pages; a page counts again after another one was read
  bool over_budget = false;      ///< the budget was exceeded, and `chunks` is empty
};

/// Chunks that are read together: `count` neighbours in a list, from `first` on.
struct ChunkRun {
  size_t first = 0;
  size_t count = 0;
};

/// A store on disk, or on a web server: reads the header, loads directory pages when they are
/// needed, and reads chunks. Several threads may call all functions at the same time.
///
/// Functions that are given a NoWait do not wait for the disk. If they would have to, they fail
/// with io_error, and set NoWait::needs_disk.
///
/// The file stays open. A store that is replaced by renaming can still be read to the end through
/// an object that was opened before. Each read fails if the file was changed in place.
class StoreFile {
 public:
  /// `directory_bytes`: the most bytes of directory pages to keep, by their size in the file. The
  /// least recently used pages are dropped first. The page in use is kept whatever its size.
  /// Errors: those of StoreReader::open, truncated (the file is shorter than its header says), and
  /// io_error. Messages begin with the path.
  static Result<std::shared_ptr<StoreFile>> open(const std::filesystem::path& path,
                                                 uint64_t directory_bytes = uint64_t{256} << 20);
  /// The same for a store that is a part of a file, such as a bundle. `path`: for messages.
  static Result<std::shared_ptr<StoreFile>> open(FileParts parts, const std::filesystem::path& path,
                                                 uint64_t directory_bytes = uint64_t{256} << 20,
                                                 StoreKind kind = StoreKind::store);
  StoreFile(const StoreFile&) = delete;
  StoreFile& operator=(const StoreFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const FileParts& file() const { return file_; }
  const StoreInfo& info() const { return info_; }
  const FileIdentity& identity() const { return identity_; }

  /// info().content_id in lower-case hexadecimal, 32 digits.
  const std::string& content() const { return content_; }

  std::span<const PageRef> pages() const { return pages_; }

  /// The bytes that a viewer reads after the header: see StoreReader::bootstrap_range.
  const CoarseRange& bootstrap() const { return bootstrap_; }
  /// The same within fewer bytes.
  CoarseRange bootstrap_within(uint64_t max_bytes) const;

  /// Bytes of the directory pages that are in memory now, by their size in the file.
  uint64_t directory_bytes() const { return resident_bytes_; }

  /// The bytes of the header, for StoreReader::open.
  std::span<const std::byte> header() const { return header_; }

  /// The bytes of a page, after its checksum was verified. Errors: not_found, io_error, truncated,
  /// checksum_mismatch.
  Result<std::vector<std::byte>> read_page(uint32_t page, NoWait* no_wait = nullptr) const;

  /// The same as in StoreReader, but they load pages as needed. Errors: those of StoreReader except
  /// page_not_resident, and those of read_page.
  Result<BlockRef> block(BlockKey key) const;
  Result<ChunkRef> chunk(BlockKey block, uint32_t band, NoWait* no_wait = nullptr) const;
  Result<std::optional<ChunkRef>> chunk_for(BlockKey block, float quantized_isovalue) const;

  /// Every chunk of a level whose band overlaps [low, high] (quantized isovalues), of the blocks in
  /// `where`, in file order. Stops when the budget is exceeded, which limits the work.
  Result<ChunkSelection> chunks_for(uint32_t level, float low, float high,
                                    const ChunkBudget& budget = {}, NoWait* no_wait = nullptr,
                                    const BlockRange& where = {}) const;

  /// The same for these blocks, in the given order, bands ascending. Errors also: not_found.
  Result<ChunkSelection> chunks_for(std::span<const BlockKey> blocks, float low, float high,
                                    const ChunkBudget& budget = {},
                                    NoWait* no_wait = nullptr) const;

  /// These chunks, in the given order. Errors: those of chunk().
  Result<ChunkSelection> chunks_at(std::span<const ChunkAddress> addresses,
                                   const ChunkBudget& budget, NoWait* no_wait = nullptr) const;

  /// Appends the chunk's bytes, after their checksum was verified; nothing on failure. Errors:
  /// io_error, truncated, checksum_mismatch.
  Result<void> read_chunk(const ChunkRef& chunk, std::vector<std::byte>& out,
                          NoWait* no_wait = nullptr) const;

  /// Divides a list of chunks into runs for read_run(), in the order of the list. Neighbours are in
  /// one run if a single read of them is faster (RandomAccessFile::max_gap_bytes). A run spans at
  /// most 4 MiB unless it is one chunk. On a disk, each chunk is a run.
  std::vector<ChunkRun> runs_of(std::span<const ChunkRef> chunks) const;

  /// Replaces `out` by the file's bytes from the beginning of the first chunk to the end of the
  /// last one, after all checksums were verified. `run`: the chunks of a run, not empty. Errors:
  /// those of read_chunk.
  Result<void> read_run(std::span<const ChunkRef> run, std::vector<std::byte>& out) const;

  /// Fills `out` with the file's bytes at `offset`, without verification. Errors: io_error,
  /// truncated.
  Result<void> read(uint64_t offset, std::span<std::byte> out, NoWait* no_wait = nullptr) const;

  /// Fails if the open file was written to after it was opened. Errors: io_error.
  Result<void> check_unchanged(NoWait* no_wait = nullptr) const;

 private:
  StoreFile(std::filesystem::path path, FileParts file, FileIdentity identity,
            std::vector<std::byte> header, StoreReader reader, uint64_t directory_bytes);

  /// Fails if the chunk ends beyond the file. Errors: truncated.
  Result<void> check_within(const ChunkRef& chunk) const;
  /// Compares the checksum of a chunk. Errors: checksum_mismatch.
  Result<void> check_bytes(const ChunkRef& chunk, std::span<const std::byte> bytes) const;

  /// Puts the file's name in front of the message.
  Error with_file_name(Error error) const;

  /// The number of the page that describes a block. Errors: not_found.
  Result<uint32_t> page_of(BlockKey block) const;

  /// A page's bytes, without verification.
  Result<std::vector<std::byte>> load_page(uint32_t page, NoWait* no_wait) const;

  /// Loads the page if it is not resident, then calls `query` with the reader. Queries of resident
  /// pages run concurrently.
  template <class Query>
  auto with_page(uint32_t page, NoWait* no_wait, Query query) const
      -> decltype(query(std::declval<const StoreReader&>()));

  /// Adds a page, unless it is resident. The caller must hold mutex_ exclusively.
  void add_page(ParsedPage&& parsed, uint32_t page) const;

  /// Drops pages until this many bytes can be added. The caller must hold mutex_ exclusively.
  void free_memory_for(uint64_t bytes) const;

  std::filesystem::path path_;
  FileParts file_;
  FileIdentity identity_;
  std::vector<std::byte> header_;
  StoreInfo info_;
  std::vector<PageRef> pages_;
  CoarseRange bootstrap_;
  std::string content_;
  uint64_t max_directory_bytes_;

  mutable std::shared_mutex mutex_;
  mutable StoreReader reader_;                        // guarded by mutex_; its header never changes
  mutable std::atomic<uint64_t> resident_bytes_ = 0;  // written under mutex_
  mutable std::atomic<uint64_t> uses_ = 0;
  mutable std::vector<std::atomic<uint64_t>> last_use_;  // of each page, by uses_
};

}  // namespace isosplat
