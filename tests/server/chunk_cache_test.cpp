#include "server/catalog/chunk_cache.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "shared/system/store_file/store_file.h"
#include "tests/server/test_store.h"

namespace isosplat::server {
namespace {

ChunkCache::Bytes bytes_of(size_t size) {
  return std::make_shared<const std::vector<std::byte>>(size);
}

class ChunkCacheTest : public ::testing::Test {
 protected:
  ChunkCacheTest() { test::write_file(path_, test::make_store(1).file); }

  ChunkCache::Store open() const { return *StoreFile::open(path_); }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "a.isosplat";
};

TEST_F(ChunkCacheTest, KeepsWhatWasUsedLast) {
  ChunkCache cache(1000);
  const auto store = open();
  for (uint64_t offset = 0; offset < 10; ++offset) cache.add(store, offset, bytes_of(100));
  EXPECT_EQ(cache.bytes(), 1000u);
  const auto first = cache.find(store, 0);
  ASSERT_TRUE(first);
  cache.add(store, 10, bytes_of(100));
  EXPECT_EQ(cache.bytes(), 1000u);
  EXPECT_EQ(cache.find(store, 0), first);
  EXPECT_FALSE(cache.find(store, 1));
  cache.add(store, 0, bytes_of(50));
  EXPECT_EQ(cache.bytes(), 950u) << "in place of the other";
  EXPECT_EQ(first->size(), 100u) << "it may still be sent";
}

TEST_F(ChunkCacheTest, KeepsNoLargeChunks) {
  ChunkCache cache(1000);
  const auto store = open();
  cache.add(store, 0, bytes_of(126));
  EXPECT_FALSE(cache.find(store, 0));
  EXPECT_EQ(cache.bytes(), 0u);
}

TEST_F(ChunkCacheTest, AnotherStoreHasOtherChunks) {
  ChunkCache cache(1000);
  auto store = open();
  cache.add(store, 0, bytes_of(100));
  EXPECT_FALSE(cache.find(open(), 0)) << "of the same file, but opened again";
  // The same holds if it has the address of a store that is no longer open.
  const StoreFile* const address = store.get();
  for (int i = 0; i < 10; ++i) {
    store.reset();
    store = open();
    EXPECT_FALSE(cache.find(store, 0));
    if (store.get() == address) break;
  }
}

}  // namespace
}  // namespace isosplat::server
