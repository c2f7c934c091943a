#include "native/builder/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <utility>

#include "native/builder/parallel.h"
#include "native/builder/verify_fields.h"
#include "shared/core/preprocess/verify_block.h"
#include "shared/system/posix_file/file_parts.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat {
namespace {

constexpr uint64_t kMaxReadBytes = uint64_t{4} << 20;  // of one read, unless a chunk is larger
constexpr const char* kRemedy = ": rebuild the store, or fetch it again";

class Verifier {
 public:
  Verifier(const FileParts& file, StoreReader reader, const VerifyOptions& options)
      : file_(file),
        file_bytes_(file.bytes()),
        reader_(std::move(reader)),
        options_(options),
        threads_(options.threads > 0 ? options.threads
                                     : std::max(1u, std::thread::hardware_concurrency())) {}

  Result<VerifyReport> verify();

 private:
  Result<void> check_content();
  Result<void> add_pages();
  Result<void> check_tiling(const LevelRef& level);
  /// Checks a block and the finer blocks that it covers. Writes the union of the intervals of each
  /// 2×2×2 of its cells to `halved`.
  Result<void> check_tree(BlockKey key, std::vector<BlockVerifier>& by_level, HalvedBlock& halved);
  Result<void> check_block(BlockKey key, BlockVerifier& verifier, HalvedBlock& halved);
  /// Reads and checks chunks that follow each other in the file. `bytes`: their sum.
  Result<void> check_chunks(std::span<const ChunkRef> chunks, uint64_t bytes,
                            BlockVerifier& verifier);

  const FileParts& file_;
  const uint64_t file_bytes_;
  StoreReader reader_;
  const VerifyOptions& options_;
  const unsigned threads_;
  std::atomic<uint64_t> chunks_{0}, cells_{0}, bytes_{0};
  std::mutex progress_mutex_;
};

Result<void> Verifier::check_content() {
  const StoreInfo& info = reader_.info();
  if (file_bytes_ != info.file_bytes) {
    return fail(file_bytes_ < info.file_bytes ? Status::truncated : Status::malformed_header,
                fmt::format("expected a file of {} bytes, found {}{}", info.file_bytes, file_bytes_,
                            kRemedy));
  }
  return verify_content(file_, info);
}

Result<void> Verifier::add_pages() {
  std::vector<std::byte> bytes;
  for (uint32_t i = 0; i < reader_.pages().size(); ++i) {
    const PageRef page = reader_.pages()[i];
    bytes.resize(page.bytes);
    if (auto read = file_.read(page.offset, bytes); !read) return read;
    if (auto added = reader_.add_page(i, bytes); !added) return added;
  }
  return {};
}

Result<void> Verifier::check_tiling(const LevelRef& level) {
  uint64_t offset = level.chunks_offset, chunks = 0;
  const Index3 blocks = level.grid.blocks;
  for (int32_t z = 0; z < blocks.z; ++z) {
    for (int32_t y = 0; y < blocks.y; ++y) {
      for (int32_t x = 0; x < blocks.x; ++x) {
        const BlockKey key{level.grid.level, {x, y, z}};
        const auto block = reader_.block(key);
        if (!block) return tl::unexpected(block.error());
        for (uint32_t s = 0; s < block->band_count; ++s) {
          const auto chunk = reader_.chunk(key, s);
          if (!chunk) return tl::unexpected(chunk.error());
          if (chunk->offset != offset) {
            return fail(
                Status::malformed_page,
                fmt::format("{}: expected offset {}, the end of the previous chunk, found {}{}",
                            name_of(*chunk), offset, chunk->offset, kRemedy));
          }
          offset += chunk->bytes;
          chunks += chunk->cells > 0;
        }
      }
    }
  }
  if (offset != level.chunks_offset + level.chunks_bytes || chunks != level.chunk_count) {
    return fail(
        Status::malformed_header,
        fmt::format(
            "level {}: expected {} chunks with {} bytes in total, found {} chunks with {} bytes{}",
            level.grid.level, level.chunk_count, level.chunks_bytes, chunks,
            offset - level.chunks_offset, kRemedy));
  }
  return {};
}

Result<void> Verifier::check_chunks(std::span<const ChunkRef> chunks, uint64_t bytes,
                                    BlockVerifier& verifier) {
  std::vector<std::byte> read_bytes(bytes);
  std::span<const std::byte> rest = read_bytes;
  if (auto read = file_.read(chunks.front().offset, read_bytes); !read) return read;
  for (const ChunkRef& chunk : chunks) {
    if (auto added = verifier.add(chunk, rest.first(chunk.bytes)); !added) return added;
    rest = rest.subspan(chunk.bytes);
    chunks_ += chunk.cells > 0;
    cells_ += chunk.cells;
    const uint64_t done = bytes_ += chunk.bytes;
    if (options_.progress) {
      const std::lock_guard lock(progress_mutex_);
      options_.progress(static_cast<double>(done) / static_cast<double>(reader_.info().file_bytes));
    }
  }
  return {};
}

Result<void> Verifier::check_block(BlockKey key, BlockVerifier& verifier, HalvedBlock& halved) {
  const auto block = reader_.block(key);
  if (!block) return tl::unexpected(block.error());
  verifier.begin(*block, block_cells(reader_.levels()[key.level].grid, key.index));
  std::vector<ChunkRef> chunks(block->band_count);
  for (uint32_t band = 0; band < block->band_count; ++band) {
    const auto chunk = reader_.chunk(key, band);
    if (!chunk) return tl::unexpected(chunk.error());
    chunks[band] = *chunk;
  }
  // check_tiling() has found that the chunks follow each other: one read has many of them.
  for (size_t first = 0, end = 0; first < chunks.size(); first = end) {
    uint64_t bytes = 0;
    do {
      bytes += chunks[end].bytes;
      ++end;
    } while (end < chunks.size() && bytes + chunks[end].bytes <= kMaxReadBytes);
    if (auto checked = check_chunks(std::span(chunks).subspan(first, end - first), bytes, verifier);
        !checked) {
      return checked;
    }
  }
  if (auto ended = verifier.end(); !ended) return ended;
  verifier.halve(halved);
  return {};
}

Result<void> Verifier::check_tree(BlockKey key, std::vector<BlockVerifier>& by_level,
                                  HalvedBlock& halved) {
  BlockVerifier& verifier = by_level[key.level];
  if (auto checked = check_block(key, verifier, halved); !checked) return checked;
  if (key.level == 0) return {};
  const Index3 blocks = reader_.levels()[key.level - 1].grid.blocks;
  HalvedBlock below;
  for (int32_t child = 0; child < 8; ++child) {
    const Index3 octant{child & 1, child >> 1 & 1, child >> 2};
    const Index3 index = key.index + key.index + octant;
    if (index.x >= blocks.x || index.y >= blocks.y || index.z >= blocks.z) continue;
    if (auto checked = check_tree({key.level - 1, index}, by_level, below); !checked) {
      return checked;
    }
    if (auto contains = verifier.contains(octant, below); !contains) return contains;
  }
  return {};
}

Result<VerifyReport> Verifier::verify() {
  if (auto checked = check_content(); !checked) return tl::unexpected(checked.error());
  if (auto added = add_pages(); !added) return tl::unexpected(added.error());
  for (const LevelRef& level : reader_.levels()) {
    if (auto checked = check_tiling(level); !checked) return tl::unexpected(checked.error());
  }
  // Subtrees of blocks are checked in parallel, from the coarsest level with enough blocks.
  const auto levels = reader_.levels();
  auto top = static_cast<uint32_t>(levels.size() - 1);
  while (top > 0 && levels[top].grid.block_count() < 8 * threads_) --top;
  const auto index_of = [](const LevelGrid& grid, size_t i) {
    const auto n = static_cast<int32_t>(i);
    return Index3{n % grid.blocks.x, n / grid.blocks.x % grid.blocks.y,
                  n / grid.blocks.x / grid.blocks.y};
  };
  std::vector<std::vector<BlockVerifier>> verifiers(threads_);
  for (auto& by_level : verifiers) by_level.resize(top + 1);
  std::vector<HalvedBlock> halves(levels[top].grid.block_count());
  std::mutex mutex;
  Result<void> result;
  parallel_for(threads_, halves.size(), [&](unsigned thread, size_t i) {
    {
      const std::lock_guard lock(mutex);
      if (!result) return;
    }
    auto checked = check_tree({top, index_of(levels[top].grid, i)}, verifiers[thread], halves[i]);
    if (checked) return;
    const std::lock_guard lock(mutex);
    if (result) result = checked;
  });
  // The coarser levels have few blocks: each is compared with the next finer one.
  for (uint32_t l = top + 1; result && l < levels.size(); ++l) {
    const LevelGrid &grid = levels[l].grid, &finer = levels[l - 1].grid;
    std::vector<HalvedBlock> above(grid.block_count());
    for (size_t i = 0; result && i < above.size(); ++i) {
      BlockVerifier& verifier = verifiers[0][0];
      const Index3 index = index_of(grid, i);
      result = check_block({l, index}, verifier, above[i]);
      for (int32_t child = 0; result && child < 8; ++child) {
        const Index3 octant{child & 1, child >> 1 & 1, child >> 2};
        const Index3 at = index + index + octant;
        if (at.x >= finer.blocks.x || at.y >= finer.blocks.y || at.z >= finer.blocks.z) continue;
        const auto n = (at.z * finer.blocks.y + at.y) * finer.blocks.x + at.x;
        result = verifier.contains(octant, halves[static_cast<size_t>(n)]);
      }
    }
    halves = std::move(above);
  }
  if (!result) return tl::unexpected(result.error());
  return VerifyReport{reader_.info(), chunks_, cells_};
}

}  // namespace

Result<VerifyReport> verify_store_file(const std::filesystem::path& path,
                                       const VerifyOptions& options) {
  auto file = PosixFile::open(path);
  if (!file) return tl::unexpected(file.error());
  const auto identity = file->identity();
  if (!identity) return tl::unexpected(identity.error());
  auto shared = std::make_shared<const PosixFile>(std::move(*file));
  return verify_store(FileParts(std::move(shared), identity->bytes), options);
}

Result<VerifyReport> verify_store(const FileParts& file, const VerifyOptions& options) {
  std::vector<std::byte> header(std::min<uint64_t>(kMaxStoreHeaderBytes, file.bytes()));
  if (auto read = file.read(0, header); !read) return tl::unexpected(read.error());
  auto reader = StoreReader::open(header);
  if (!reader) return tl::unexpected(reader.error());
  auto report = Verifier(file, std::move(*reader), options).verify();
  if (!report || report->info.fields.empty()) return report;
  const auto store = StoreFile::open(file, file.file().name());
  if (!store) return tl::unexpected(store.error());
  const auto chunks = verify_fields(**store, options);
  if (!chunks) return tl::unexpected(chunks.error());
  report->field_chunks = *chunks;
  return report;
}

}  // namespace isosplat
