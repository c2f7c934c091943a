#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "isosplat/decoder.h"
#include "isosplat/file_store.h"
#include "isosplat/store.h"
#include "shared/core/store/store_reader.h"

namespace isosplat {
namespace {

constexpr double kIsovalue = 100;
const std::string kGolden = ISOSPLAT_SOURCE_DIR "/tests/golden/v1.0/";

std::vector<std::byte> golden(const std::string& name) {
  std::ifstream file(kGolden + name, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

template <class T>
Status status_of(const Result<T>& result) {
  return result ? Status::ok : result.error().status;
}

class Library : public testing::Test {
 protected:
  Library() : bytes_(golden("u8.isosplat")) {}

  Store open() {
    Result<Store> store = Store::open(bytes_);
    if (!store) throw std::runtime_error(store.error().message);
    return std::move(*store);
  }
  std::span<const std::byte> range(uint64_t offset, uint64_t size) const {
    return std::span(bytes_).subspan(offset, size);
  }
  void add_pages(Store& store, uint32_t level, double isovalue) {
    for (const Page& page : store.missing_pages(level, isovalue)) {
      ASSERT_EQ(status_of(store.add_page(page.index, range(page.offset, page.bytes))), Status::ok);
    }
  }
  /// The first chunk of level 0, with its bytes.
  Chunk first_chunk(Store& store) {
    add_pages(store, 0, kIsovalue);
    return store.chunks_for(0, kIsovalue).value().at(0);
  }

  std::vector<std::byte> bytes_;
};

TEST_F(Library, DescribesTheStore) {
  const Store store = open();
  const StoreInfo info = StoreReader::open(bytes_)->info();
  EXPECT_EQ(store.volume().voxels, info.grid.voxels);
  EXPECT_EQ(store.volume().levels, info.levels);
  EXPECT_EQ(store.volume().min_value, info.mapping.value(info.range.min));
  EXPECT_EQ(store.volume().max_value, info.mapping.value(info.range.max));
  EXPECT_EQ(store.file_bytes(), bytes_.size());
  EXPECT_EQ(store.metadata(), info.metadata);
}

TEST_F(Library, ProjectsOnePointForEachActiveCellOfEachLevel) {
  Store store = open();
  Decoder decoder(store.volume());
  Cells cells;
  for (uint32_t level = 0; level < store.volume().levels; ++level) {
    add_pages(store, level, kIsovalue);
    EXPECT_TRUE(store.missing_pages(level, kIsovalue).empty());
    const auto chunks = store.chunks_for(level, kIsovalue);
    ASSERT_EQ(status_of(chunks), Status::ok);
    ASSERT_FALSE(chunks->empty());
    for (const Chunk& chunk : *chunks) {
      ASSERT_EQ(status_of(decoder.decode(chunk, range(chunk.offset, chunk.bytes), cells)),
                Status::ok);
      ASSERT_EQ(cells.size(), chunk.cells);
      const SampleArrays samples = cells.samples();
      ASSERT_EQ(samples.positions.size(), cells.size());
      size_t active = 0;
      for (const auto& [min, max] : samples.intervals)
        active += min <= kIsovalue && kIsovalue < max;
      const PointArrays points = cells.project(kIsovalue);
      EXPECT_EQ(points.positions.size(), active);
      EXPECT_EQ(points.normals.size(), active);
      EXPECT_TRUE(cells.project(std::nan("")).positions.empty());
    }
  }
}

TEST_F(Library, RefusesInvalidQueries) {
  Store store = open();
  EXPECT_EQ(status_of(store.chunks_for(0, kIsovalue)), Status::page_not_resident);
  add_pages(store, 0, kIsovalue);
  EXPECT_EQ(status_of(store.chunks_for(0, kIsovalue)), Status::ok);
  EXPECT_EQ(status_of(store.chunks_for(store.volume().levels, kIsovalue)), Status::not_found);
  EXPECT_TRUE(store.missing_pages(store.volume().levels, kIsovalue).empty());
  for (const double isovalue : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(status_of(store.chunks_for(0, isovalue)), Status::invalid_argument);
    EXPECT_TRUE(store.missing_pages(0, isovalue).empty());
  }
  EXPECT_EQ(status_of(store.add_page(1u << 20, {})), Status::not_found);
  EXPECT_EQ(status_of(Store::open(range(0, 3))), Status::not_a_store);
  EXPECT_EQ(status_of(Store::open(range(0, 100))), Status::truncated);
  EXPECT_TRUE(store.chunks_for(0, store.volume().max_value + 1)->empty());
}

TEST_F(Library, RefusesBytesOfAnotherChunk) {
  Store store = open();
  const Chunk chunk = first_chunk(store);
  Decoder decoder(store.volume());
  Cells cells;
  const auto right = range(chunk.offset, chunk.bytes);
  EXPECT_EQ(status_of(decoder.decode(chunk, right.first(right.size() - 1), cells)),
            Status::truncated);
  std::vector<std::byte> flipped(right.begin(), right.end());
  flipped[flipped.size() / 2] ^= std::byte{1};
  EXPECT_EQ(status_of(decoder.decode(chunk, flipped, cells)), Status::checksum_mismatch);
  EXPECT_EQ(status_of(decoder.decode(chunk, right, cells)), Status::ok);
}

TEST_F(Library, RefusesChunksOutsideTheVolume) {
  Store store = open();
  const Chunk chunk = first_chunk(store);
  Decoder decoder(store.volume());
  Cells cells;
  const auto bytes = range(chunk.offset, chunk.bytes);
  const auto decode = [&](auto change) {
    Chunk changed = chunk;
    change(changed);
    return status_of(decoder.decode(changed, bytes, cells));
  };
  EXPECT_EQ(decode([](Chunk& c) { c.level = 31; }), Status::invalid_argument);
  EXPECT_EQ(decode([](Chunk& c) { c.block.y = -1; }), Status::invalid_argument);
  EXPECT_EQ(decode([](Chunk& c) { c.block.z = 1 << 20; }), Status::invalid_argument);
  EXPECT_EQ(decode([](Chunk& c) { c.band_end = c.band_begin; }), Status::invalid_argument);
  EXPECT_EQ(decode([](Chunk& c) { c.cells = 0; }), Status::invalid_argument);
  EXPECT_EQ(decode([](Chunk& c) { c.cells += 1; }), Status::malformed_chunk);
}

TEST_F(Library, ReadsAFileAsItReadsBytes) {
  Store store = open();
  const auto file = FileStore::open(kGolden + "u8.isosplat");
  ASSERT_EQ(status_of(file), Status::ok);
  EXPECT_EQ(file->volume().voxels, store.volume().voxels);
  EXPECT_EQ(file->metadata(), store.metadata());
  for (uint32_t level = 0; level < store.volume().levels; ++level) {
    add_pages(store, level, kIsovalue);
    const auto expected = store.chunks_for(level, kIsovalue);
    const auto chunks = file->chunks_for(level, kIsovalue);
    ASSERT_EQ(status_of(chunks), Status::ok);
    ASSERT_EQ(chunks->size(), expected->size());
    for (const Chunk& chunk : *chunks) {
      const auto found = file->read_chunk(chunk);
      ASSERT_EQ(status_of(found), Status::ok);
      EXPECT_TRUE(std::ranges::equal(*found, range(chunk.offset, chunk.bytes)));
    }
  }
}

TEST_F(Library, ReportsErrorsOfFiles) {
  EXPECT_EQ(status_of(FileStore::open(kGolden + "absent.isosplat")), Status::io_error);
  EXPECT_EQ(status_of(FileStore::open(kGolden + "u8.txt")), Status::not_a_store);
  const auto file = FileStore::open(kGolden + "u8.isosplat");
  ASSERT_EQ(status_of(file), Status::ok);
  EXPECT_EQ(status_of(file->chunks_for(31, kIsovalue)), Status::not_found);
  EXPECT_EQ(status_of(file->chunks_for(0, std::nan(""))), Status::invalid_argument);
  Chunk chunk = file->chunks_for(0, kIsovalue).value().at(0);
  chunk.offset = bytes_.size();
  EXPECT_EQ(status_of(file->read_chunk(chunk)), Status::truncated);
  chunk.offset = 0;
  EXPECT_EQ(status_of(file->read_chunk(chunk)), Status::checksum_mismatch);
}

}  // namespace
}  // namespace isosplat
