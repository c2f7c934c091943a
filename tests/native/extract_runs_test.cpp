// Chunks of a file in which reads have a cost, such as one of a web server, are read in runs.
#include <gtest/gtest.h>

#include <mutex>
#include <random>

#include "native/builder/array_source.h"
#include "native/extract/chunk_reading.h"
#include "shared/system/posix_file/posix_file.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

/// A file on the disk that records reads, and whose reads cost as much as `gap` bytes.
class CostlyFile final : public RandomAccessFile {
 public:
  CostlyFile(PosixFile file, uint64_t gap) : file_(std::move(file)), gap_(gap) {}

  const std::string& name() const override { return file_.name(); }
  Result<FileIdentity> identity(NoWait* no_wait) const override { return file_.identity(no_wait); }
  Result<void> read(uint64_t offset, std::span<std::byte> out, NoWait* no_wait) const override {
    const std::scoped_lock lock(mutex_);
    ++reads;
    return file_.read(offset, out, no_wait);
  }
  uint64_t max_gap_bytes() const override { return gap_; }

  mutable size_t reads = 0;

 private:
  PosixFile file_;
  uint64_t gap_;
  mutable std::mutex mutex_;
};

class ChunkRuns : public testing::Test {
 protected:
  void SetUp() override {
    VolumeGrid grid;
    grid.voxels = {200, 150, 70};
    std::mt19937 random(3);
    std::vector<uint8_t> voxels(200 * 150 * 70);
    for (auto& voxel : voxels) voxel = static_cast<uint8_t>(random() % 9);
    ASSERT_TRUE(build_store_file<uint8_t>(grid, voxels, path_));
  }

  /// The store, and the file that it reads.
  std::shared_ptr<StoreFile> open(uint64_t gap) {
    auto file = PosixFile::open(path_);
    const uint64_t bytes = file->identity()->bytes;
    file_ = std::make_shared<CostlyFile>(std::move(*file), gap);
    auto store = StoreFile::open(FileParts(file_, bytes), path_);
    EXPECT_TRUE(store) << store.error().message;
    return *store;
  }

  std::vector<ChunkRef> chunks(const StoreFile& store) {
    return *chunks_of(store, 4.5, ExtractOptions{});
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "noise.isosplat";
  std::shared_ptr<CostlyFile> file_;
};

TEST_F(ChunkRuns, OnADiskEachChunkIsARun) {
  const auto store = open(0);
  const auto all = chunks(*store);
  ASSERT_GT(all.size(), 10u);
  EXPECT_EQ(store->runs_of(all).size(), all.size());
}

TEST_F(ChunkRuns, CoverAllChunksInTheirOrderWithinFourMebibytes) {
  for (const uint64_t gap : {uint64_t{1}, uint64_t{10'000}, uint64_t{1} << 40}) {
    const auto store = open(gap);
    const auto all = chunks(*store);
    size_t next = 0;
    for (const ChunkRun& run : store->runs_of(all)) {
      ASSERT_EQ(run.first, next);
      ASSERT_GT(run.count, 0u);
      next += run.count;
      const ChunkRef &first = all[run.first], &last = all[next - 1];
      const uint64_t bytes = last.offset + last.bytes - first.offset;
      EXPECT_TRUE(run.count == 1 || bytes <= 4u << 20);
    }
    EXPECT_EQ(next, all.size());
  }
}

TEST_F(ChunkRuns, HaveTheBytesOfTheirChunksWithFewerReads) {
  const auto store = open(uint64_t{1} << 20);
  const auto all = chunks(*store);
  const auto plain = open(0);
  const auto runs = store->runs_of(all);
  EXPECT_LT(runs.size(), all.size() / 2);
  std::vector<std::byte> bytes, expected;
  for (const ChunkRun& run : runs) {
    const auto part = std::span(all).subspan(run.first, run.count);
    ASSERT_TRUE(store->read_run(part, bytes));
    for (const ChunkRef& chunk : part) {
      expected.clear();
      ASSERT_TRUE(plain->read_chunk(chunk, expected));
      const auto found = std::span(bytes).subspan(chunk.offset - part.front().offset, chunk.bytes);
      EXPECT_TRUE(std::ranges::equal(found, expected));
    }
  }
}

TEST_F(ChunkRuns, OfListsThatAreNotInFileOrderAreReadAsWell) {
  const auto store = open(uint64_t{1} << 20);
  auto all = chunks(*store);
  std::ranges::reverse(all);
  EXPECT_EQ(store->runs_of(all).size(), all.size());
}

TEST_F(ChunkRuns, WithADamagedChunkNameIt) {
  const auto store = open(uint64_t{1} << 20);
  auto all = chunks(*store);
  all[1].checksum ^= 1;
  std::vector<std::byte> bytes;
  const auto read = store->read_run(std::span(all).first(3), bytes);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().status, Status::checksum_mismatch);
  all[1].offset = UINT64_MAX - 1;
  EXPECT_EQ(store->read_run(std::span(all).first(2), bytes).error().status, Status::truncated);
}

TEST_F(ChunkRuns, AnExtractionReadsEachOnce) {
  const auto store = open(uint64_t{1} << 20);
  const auto all = chunks(*store);
  const size_t before = file_->reads;
  std::vector<std::atomic<int>> seen(all.size());
  const auto done = for_each_chunk(
      *store, all, 3,
      [&](unsigned, ChunkDecoder&, std::span<const std::byte> bytes, size_t i) -> Result<void> {
        EXPECT_EQ(bytes.size(), all[i].bytes);
        ++seen[i];
        return {};
      });
  ASSERT_TRUE(done);
  EXPECT_EQ(file_->reads - before, store->runs_of(all).size());
  for (const auto& count : seen) EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace isosplat
