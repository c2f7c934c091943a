#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "shared/core/store/byte_order.h"
#include "shared/core/store/checksum.h"
#include "shared/core/store/directory_page.h"
#include "shared/core/store/format.h"
#include "shared/core/store/store_header.h"
#include "shared/core/store/store_reader.h"
#include "shared/core/store/store_writer.h"

namespace isosplat {
namespace {

std::span<const std::byte> as_bytes(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

struct Written {
  StoreInfo info;
  std::vector<std::byte> bytes;
};

/// A store of random bands whose chunks are random bytes, since the directory does not depend on
/// the content of chunks.
Written random_store(Index3 voxels, uint32_t seed, const std::string& metadata = "{}") {
  std::mt19937 random(seed);
  MemorySink sink;
  auto writer = StoreWriter::create(voxels, 1000, sink);
  EXPECT_TRUE(writer);
  for (uint32_t l = 0; l < level_count(voxels); ++l) {
    const LevelGrid grid = level_grid(voxels, l);
    for (uint64_t b = 0; b < grid.block_count(); ++b) {
      if (random() % 4 == 0) {
        EXPECT_TRUE(writer->add_block({}, {}, {}));
        continue;
      }
      std::vector<BandChunk> bands;
      std::vector<std::byte> bytes;
      const CellInterval interval{static_cast<QuantizedValue>(10 + random() % 50),
                                  static_cast<QuantizedValue>(100 + random() % 100)};
      for (uint32_t end = interval.min; end < interval.max;) {
        end = std::min<uint32_t>(end + 1 + uint32_t(random() % 40), interval.max);
        const uint32_t size = random() % 8 == 0 ? 0 : 1 + uint32_t(random() % 20);
        bands.push_back({end, size ? 1 : 0u, size});
        for (uint32_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(random()));
      }
      EXPECT_TRUE(writer->add_block(interval, bands, bytes));
    }
  }
  StoreInfo info;
  info.grid.voxels = voxels;
  info.grid.spacing = {0.5, 0.75, 2};
  info.grid.origin = {-1, 2, 3.5};
  info.mapping.offset = -7;
  info.mapping.scale = 0.25;
  info.mapping.bits = 16;
  info.range = {10, 200};
  info.metadata = metadata;
  auto finished = writer->finish(info);
  EXPECT_TRUE(finished) << (finished ? "" : finished.error().message);
  return {*finished, sink.bytes};
}

void add_all_pages(StoreReader& reader, std::span<const std::byte> bytes) {
  for (uint32_t i = 0; i < reader.pages().size(); ++i) {
    const PageRef page = reader.pages()[i];
    const auto added = reader.add_page(i, bytes.subspan(page.offset, page.bytes));
    ASSERT_TRUE(added) << added.error().message;
  }
}

/// Recomputes the header's checksum after a test has changed the header.
void reseal(std::vector<std::byte>& store) {
  const auto header_bytes = static_cast<size_t>(read_le(store.data() + 12, 4));
  write_le(store.data() + header_bytes - 8, 8,
           checksum64(std::span(store).first(header_bytes - 8)));
}

TEST(Store, HeaderHasTheWrittenFields) {
  const Written store = random_store({300, 200, 130}, 1, R"({"name":"x"})");
  const auto reader = StoreReader::open(store.bytes);
  ASSERT_TRUE(reader) << reader.error().message;
  const StoreInfo& info = reader->info();
  EXPECT_EQ(info.grid.voxels, (Index3{300, 200, 130}));
  EXPECT_EQ(info.grid.spacing, (Vec3d{0.5, 0.75, 2}));
  EXPECT_EQ(info.grid.origin, (Vec3d{-1, 2, 3.5}));
  EXPECT_EQ(info.mapping.offset, -7);
  EXPECT_EQ(info.mapping.scale, 0.25);
  EXPECT_EQ(info.range, (CellInterval{10, 200}));
  EXPECT_EQ(info.metadata, R"({"name":"x"})");
  EXPECT_EQ(info.file_bytes, store.bytes.size());
  EXPECT_EQ(info.levels, level_count({300, 200, 130}));
  EXPECT_EQ(info.content_id, store.info.content_id);
  EXPECT_EQ(info.chunk_count, store.info.chunk_count);
  EXPECT_EQ(reader->levels().size(), info.levels);
  const CoarseRange all = reader->coarse_range(UINT64_MAX);
  EXPECT_EQ(all.first_level, 0u);
  EXPECT_EQ(all.offset, info.header_bytes);
  EXPECT_EQ(all.offset + all.bytes, info.file_bytes);
  EXPECT_EQ(reader->coarse_range(0).first_level, info.levels - 1);
  const CoarseRange coarse = reader->coarse_range(kBootstrapBytes);
  const CoarseRange bootstrap = reader->bootstrap_range();
  EXPECT_EQ(bootstrap.first_level, coarse.first_level);
  EXPECT_EQ(bootstrap.offset, coarse.offset);
  EXPECT_GE(bootstrap.bytes, coarse.bytes);
  EXPECT_LE(bootstrap.bytes, std::max(coarse.bytes + 256, kBootstrapBytes / 4 * 5));
  // The range ends with a page, and would be too long with the next page.
  uint64_t end = 0;
  for (const PageRef& page : reader->pages()) {
    if (page.offset + page.bytes <= bootstrap.offset + bootstrap.bytes) {
      end = page.offset + page.bytes;
    } else {
      EXPECT_GT(page.offset + page.bytes - bootstrap.offset, kBootstrapBytes / 4 * 5);
    }
  }
  EXPECT_EQ(end, bootstrap.offset + bootstrap.bytes);
}

TEST(Store, ASpacingReplacesThatOfTheHeader) {
  const Written written = random_store({20, 30, 40}, 1);
  auto store = StoreReader::open(written.bytes);
  ASSERT_TRUE(store);
  ASSERT_TRUE(store->set_spacing({0.25, 3, 1}));
  EXPECT_EQ(store->info().grid.spacing.x, 0.25);
  EXPECT_EQ(store->info().grid.spacing.y, 3);
  EXPECT_EQ(store->info().grid.spacing.z, 1);
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double wrong : {0.0, -1.0, std::nan(""), infinite}) {
    const auto set = store->set_spacing({1, 1, wrong});
    ASSERT_FALSE(set);
    EXPECT_EQ(set.error().status, Status::invalid_argument);
  }
  EXPECT_EQ(store->info().grid.spacing.z, 1);
}

TEST(Store, TheBootstrapRangeHasSmallPagesInAnyCase) {
  const Written store = random_store({40, 40, 40}, 1);
  const auto reader = StoreReader::open(std::span(store.bytes).first(store.info.header_bytes));
  ASSERT_TRUE(reader);
  const CoarseRange bootstrap = reader->bootstrap_range(0);
  EXPECT_EQ(bootstrap.first_level, reader->info().levels - 1);
  EXPECT_GT(bootstrap.bytes, reader->coarse_range(0).bytes);
  EXPECT_EQ(bootstrap.offset + bootstrap.bytes, store.info.file_bytes);
}

TEST(Store, EveryBlockAnswersForEveryIsovalue) {
  const Written store = random_store({400, 300, 200}, 2);
  auto reader = StoreReader::open(std::span(store.bytes).first(store.info.header_bytes));
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->chunk_for({0, {0, 0, 0}}, 50).error().status, Status::page_not_resident);
  EXPECT_FALSE(reader->missing_pages(0, 0, 65535).empty());
  add_all_pages(*reader, store.bytes);
  EXPECT_TRUE(reader->missing_pages(0, 0, 65535).empty());
  uint64_t chunks = 0;
  for (const LevelRef& level : reader->levels()) {
    for (int32_t z = 0; z < level.grid.blocks.z; ++z) {
      for (int32_t y = 0; y < level.grid.blocks.y; ++y) {
        for (int32_t x = 0; x < level.grid.blocks.x; ++x) {
          const BlockKey key{level.grid.level, {x, y, z}};
          const BlockRef block = *reader->block(key);
          uint32_t begin = block.interval.min;
          for (uint32_t s = 0; s < block.band_count; ++s) {
            const ChunkRef chunk = *reader->chunk(key, s);
            EXPECT_EQ(chunk.band_begin, begin);
            EXPECT_EQ(chunk.band, s);
            begin = chunk.band_end;
            if (chunk.bytes == 0) continue;
            ++chunks;
            EXPECT_EQ(checksum32(std::span(store.bytes).subspan(chunk.offset, chunk.bytes)),
                      chunk.checksum);
          }
          EXPECT_EQ(begin, block.interval.max);
          for (float quantized_isovalue :
               {0.f, 9.5f, 10.f, 57.f, 99.5f, 100.f, 163.25f, 199.f, 200.f}) {
            const auto chunk = *reader->chunk_for(key, quantized_isovalue);
            if (!chunk) continue;
            EXPECT_TRUE(is_active(block.interval, quantized_isovalue));
            EXPECT_LE(static_cast<float>(chunk->band_begin), quantized_isovalue);
            EXPECT_LT(quantized_isovalue, static_cast<float>(chunk->band_end));
          }
          EXPECT_EQ(reader->chunk(key, block.band_count).error().status, Status::not_found);
        }
      }
    }
    EXPECT_EQ(reader->chunks_for(level.grid.level, 0, 65535)->size(), level.chunk_count);
    std::vector<ChunkRef> expected;
    const std::vector<ChunkRef> every = *reader->chunks_for(level.grid.level, 0, 65535);
    for (const ChunkRef& chunk : every) {
      if (chunk.band_begin <= 80.5f && 60 < chunk.band_end) expected.push_back(chunk);
    }
    EXPECT_EQ(reader->chunks_for(level.grid.level, 60, 80.5f)->size(), expected.size());
  }
  EXPECT_EQ(chunks, reader->info().chunk_count);
  EXPECT_EQ(reader->block({0, {0, 0, -1}}).error().status, Status::not_found);
  EXPECT_EQ(reader->block({99, {0, 0, 0}}).error().status, Status::not_found);
  EXPECT_EQ(reader->add_page(100000, {}).error().status, Status::not_found);
}

TEST(Store, NotANumberIsRefusedAsIsovalue) {
  const Written store = random_store({70, 70, 70}, 3);
  auto reader = StoreReader::open(store.bytes);
  add_all_pages(*reader, store.bytes);
  EXPECT_FALSE(*reader->chunk_for({0, {0, 0, 0}}, std::nanf("")));
  EXPECT_TRUE(reader->chunks_for(0, std::nanf(""), std::nanf(""))->empty());
}

TEST(Store, TheSameContentHasTheSameId) {
  EXPECT_EQ(random_store({70, 70, 70}, 4).info.content_id,
            random_store({70, 70, 70}, 4).info.content_id);
  EXPECT_NE(random_store({70, 70, 70}, 4).info.content_id,
            random_store({70, 70, 70}, 5).info.content_id);
  EXPECT_NE(random_store({70, 70, 70}, 4).info.content_id,
            random_store({70, 70, 70}, 4, "{ }").info.content_id);
}

TEST(Store, EveryTruncationOfTheHeaderIsRefused) {
  const Written store = random_store({100, 80, 70}, 6);
  for (size_t n = 0; n < store.info.header_bytes; ++n) {
    const auto reader = StoreReader::open(std::span(store.bytes).first(n));
    ASSERT_FALSE(reader) << n;
    EXPECT_EQ(reader.error().status, n < 8 ? Status::not_a_store : Status::truncated) << n;
  }
}

TEST(Store, EveryFlippedBitOfTheHeaderIsRefused) {
  const Written store = random_store({100, 80, 70}, 7);
  auto bytes = store.bytes;
  for (size_t bit = 0; bit < 8 * size_t{store.info.header_bytes}; ++bit) {
    bytes[bit / 8] ^= std::byte{1} << (bit % 8);
    const auto reader = StoreReader::open(bytes);
    ASSERT_FALSE(reader) << bit;
    const Status status = reader.error().status;
    const size_t at = bit / 8;
    if (at < 8) {
      EXPECT_EQ(status, Status::not_a_store) << bit;
    } else if (at < 10) {
      EXPECT_EQ(status, Status::unsupported_version) << bit;
    } else if (at >= 12 && at < 16) {
      EXPECT_TRUE(status == Status::malformed_header || status == Status::truncated ||
                  status == Status::checksum_mismatch)
          << bit;
    } else {
      EXPECT_EQ(status, Status::checksum_mismatch) << bit;
    }
    EXPECT_NE(reader.error().message.find(": "), std::string::npos);
    bytes[bit / 8] ^= std::byte{1} << (bit % 8);
  }
}

TEST(Store, EveryFlippedBitAndTruncationOfAPageIsRefused) {
  const Written store = random_store({200, 80, 70}, 8);
  auto reader = StoreReader::open(store.bytes);
  ASSERT_TRUE(reader);
  for (uint32_t p = 0; p < reader->pages().size(); ++p) {
    const PageRef page = reader->pages()[p];
    const auto whole = std::span(store.bytes).subspan(page.offset, page.bytes);
    std::vector<std::byte> bytes(whole.begin(), whole.end());
    for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      bytes[bit / 8] ^= std::byte{1} << (bit % 8);
      EXPECT_EQ(reader->add_page(p, bytes).error().status, Status::checksum_mismatch);
      bytes[bit / 8] ^= std::byte{1} << (bit % 8);
    }
    for (size_t n = 0; n < bytes.size(); ++n) {
      EXPECT_EQ(reader->add_page(p, whole.first(n)).error().status, Status::truncated);
    }
    EXPECT_FALSE(reader->is_resident(p));
  }
}

TEST(Store, InconsistentHeadersAreRefused) {
  const Written store = random_store({200, 80, 70}, 9);
  // Changes any field of any section, and corrects the checksum: either it is a field that can
  // have any value (a spacing, the metadata), or it is malformed; nothing else, and no crash.
  std::mt19937 random(10);
  for (size_t at = 8; at < store.info.header_bytes - 8; ++at) {
    for (const int value : {0x00, 0x01, 0x7f, 0x80, 0xff}) {
      auto bytes = store.bytes;
      bytes[at] = static_cast<std::byte>(value);
      if (at >= 12 && at < 16) continue;
      reseal(bytes);
      const auto reader = StoreReader::open(bytes);
      if (reader) continue;
      const Status status = reader.error().status;
      EXPECT_TRUE(status == Status::malformed_header || (status == Status::unsupported_version))
          << at << " " << status_name(status);
    }
  }
}

// Section VOLU is the first: its direction begins at byte 64 of its payload.
TEST(Store, LinearlyDependentAxesAreRefused) {
  const Written store = random_store({70, 70, 70}, 9);
  const size_t direction = kFixedHeaderBytes + kSectionHeaderBytes + 64;
  const auto opened = [&](const Matrix3d& axes) {
    auto bytes = store.bytes;
    std::memcpy(bytes.data() + direction, axes.data(), sizeof axes);
    reseal(bytes);
    return StoreReader::open(bytes);
  };
  const Matrix3d sheared{1, 0.6, 0, 0, 0.8, 0.6, 0, 0, 0.8};
  const auto reader = opened(sheared);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->info().grid.direction, sheared);
  EXPECT_TRUE(opened({-1, 0, 0, 0, 1, 0, 0, 0, 1}));
  for (const Matrix3d& axes :
       {Matrix3d{}, Matrix3d{2, 0, 0, 0, 1, 0, 0, 0, 1}, Matrix3d{1, 1, 0, 0, 0, 0, 0, 0, 1},
        Matrix3d{std::nan(""), 0, 0, 0, 1, 0, 0, 0, 1}}) {
    const auto refused = opened(axes);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().status, Status::malformed_header);
    EXPECT_NE(refused.error().message.find("direction"), std::string::npos);
  }
}

TEST(Store, AFutureVersionIsRefusedAsNewer) {
  Written store = random_store({70, 70, 70}, 11);
  auto bytes = store.bytes;
  write_le(bytes.data() + 8, 2, 2);
  reseal(bytes);
  EXPECT_EQ(StoreReader::open(bytes).error().status, Status::unsupported_version);
  EXPECT_NE(StoreReader::open(bytes).error().message.find("newer"), std::string::npos);
  bytes = store.bytes;
  write_le(bytes.data() + 10, 2, 7);  // a minor version: readable
  reseal(bytes);
  EXPECT_TRUE(StoreReader::open(bytes));
}

TEST(Store, UnknownSectionsAreSkippedOnlyIfOptional) {
  Written store = random_store({70, 70, 70}, 12);
  // The padding after the metadata has room for an empty section.
  const size_t end = store.info.header_bytes - 16;
  auto bytes = store.bytes;
  write_le(bytes.data() + 24, 4, 5);
  size_t at = kFixedHeaderBytes;
  for (int i = 0; i < 4; ++i) {
    at += kSectionHeaderBytes + padded_to_8(static_cast<size_t>(read_le(bytes.data() + at + 4, 4)));
  }
  ASSERT_LE(at, end);
  write_le(bytes.data() + at, 4, section_tag('x', 'T', 'R', 'A'));
  reseal(bytes);
  EXPECT_TRUE(StoreReader::open(bytes));
  write_le(bytes.data() + at, 4, section_tag('X', 'T', 'R', 'A'));
  reseal(bytes);
  EXPECT_EQ(StoreReader::open(bytes).error().status, Status::unsupported_version);
  write_le(bytes.data() + at, 4, kVolumeTag);
  reseal(bytes);
  EXPECT_EQ(StoreReader::open(bytes).error().status, Status::malformed_header);
  write_le(bytes.data() + at + 4, 4, 0xffffffff);
  reseal(bytes);
  EXPECT_EQ(StoreReader::open(bytes).error().status, Status::malformed_header);
}

TEST(Store, InconsistentPagesAreRefused) {
  // Changes every byte of a page, and corrects the checksums.
  const Written store = random_store({200, 80, 70}, 13);
  const auto header = parse_store_header(store.bytes);
  ASSERT_TRUE(header);
  uint32_t accepted = 0, refused = 0;
  for (uint32_t p = 0; p < header->pages.size(); ++p) {
    const PageRef& page = header->pages[p];
    for (size_t at = 0; at < page.bytes; ++at) {
      for (const int flip : {0x01, 0x10, 0x80, 0xff}) {
        auto bytes = store.bytes;
        bytes[page.offset + at] ^= static_cast<std::byte>(flip);
        StoreHeader changed = *header;
        changed.pages[p].checksum = checksum32(std::span(bytes).subspan(page.offset, page.bytes));
        const auto resealed = write_store_header(changed);
        ASSERT_TRUE(resealed);
        auto reader = StoreReader::open(*resealed);
        ASSERT_TRUE(reader);
        const auto added = reader->add_page(p, std::span(bytes).subspan(page.offset, page.bytes));
        if (added) {
          ++accepted;  // a checksum, an offset, a size or a band's end: any value is consistent
        } else {
          ++refused;
          EXPECT_EQ(added.error().status, Status::malformed_page) << at;
        }
      }
    }
  }
  EXPECT_GT(refused, accepted / 10);
}

TEST(Store, BandsThatOverlapOrLeaveAGapAreRefused) {
  const Written store = random_store({200, 80, 70}, 14);
  const auto header = parse_store_header(store.bytes);
  ASSERT_TRUE(header);
  const PageRef& largest =
      *std::max_element(header->pages.begin(), header->pages.end(),
                        [](const PageRef& a, const PageRef& b) { return a.bytes < b.bytes; });
  const LevelRef& level = header->levels[largest.level];
  const auto bytes = std::span(store.bytes).subspan(largest.offset, largest.bytes);
  const auto sound = parse_page(bytes, largest, level);
  ASSERT_TRUE(sound);
  const auto several =
      std::find_if(sound->blocks.begin(), sound->blocks.end(),
                   [](const DirectoryPage::Block& block) { return block.band_count >= 3; });
  ASSERT_NE(several, sound->blocks.end());
  const auto status = [&](uint32_t band, int change) {
    DirectoryPage page = *sound;
    page.chunks[several->first_chunk + band].band_end += static_cast<uint16_t>(change);
    const std::vector<std::byte> changed = write_page(page);
    PageRef ref = largest;
    ref.checksum = checksum32(changed);
    const auto parsed = parse_page(changed, ref, level);
    return parsed ? Status::ok : parsed.error().status;
  };
  const auto end = [&](uint32_t band) {
    return int{sound->chunks[several->first_chunk + band].band_end};
  };
  const uint32_t last = several->band_count - 1;
  EXPECT_EQ(status(0, 0), Status::ok);
  EXPECT_EQ(status(0, end(1) - end(0)), Status::malformed_page) << "nothing is left of the second";
  EXPECT_EQ(status(0, end(1) - end(0) + 1), Status::malformed_page) << "it reaches into the third";
  EXPECT_EQ(status(1, several->interval.min - end(1)), Status::malformed_page) << "it goes back";
  EXPECT_EQ(status(last, -1), Status::malformed_page) << "a gap before the interval's end";
  EXPECT_EQ(status(last, 1), Status::malformed_page) << "beyond the interval's end";
}

TEST(Store, BlocksOutOfRangeAreNotFound) {
  const Written store = random_store({200, 80, 70}, 15);
  auto reader = StoreReader::open(store.bytes);
  ASSERT_TRUE(reader);
  add_all_pages(*reader, store.bytes);
  const Index3 blocks = level_grid({200, 80, 70}, 0).blocks;
  ASSERT_TRUE(reader->block({0, {blocks.x - 1, blocks.y - 1, blocks.z - 1}}));
  for (const BlockKey& key :
       {BlockKey{0, {blocks.x, 0, 0}}, BlockKey{0, {0, blocks.y, 0}}, BlockKey{0, {0, 0, blocks.z}},
        BlockKey{0, {-1, 0, 0}}, BlockKey{0, {0, INT32_MIN, 0}}, BlockKey{0, {0, 0, INT32_MAX}},
        BlockKey{store.info.levels, {0, 0, 0}}, BlockKey{UINT32_MAX, {0, 0, 0}}}) {
    EXPECT_EQ(reader->block(key).error().status, Status::not_found);
  }
  EXPECT_FALSE(reader->add_page(static_cast<uint32_t>(reader->pages().size()), store.bytes));
}

TEST(Store, CountsBeyondTheFileAllocateNothing) {
  const Written store = random_store({200, 80, 70}, 16);
  const auto peak_bytes = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return int64_t{usage.ru_maxrss} * 1024;
  };
  const int64_t before = peak_bytes();
  for (size_t at = 16; at + 4 <= store.info.header_bytes - 8; at += 4) {
    for (const uint64_t count : {0xffffffffu, 0x7fffffffu, 0x10000000u}) {
      auto bytes = store.bytes;
      write_le(bytes.data() + at, 4, count);
      reseal(bytes);
      const auto reader = StoreReader::open(bytes);
      if (!reader) continue;
      EXPECT_LE(reader->pages().size(), bytes.size());
    }
  }
  // If the count were trusted, it would take at least 256 MB.
  EXPECT_LT(peak_bytes() - before, int64_t{64} << 20);
}

TEST(Store, SizesBeyondTheFormatAreRefused) {
  MemorySink sink;
  EXPECT_EQ(StoreWriter::create({1, 5, 5}, 0, sink).error().status, Status::no_cells);
  EXPECT_EQ(StoreWriter::create({5, 5, (1 << 20) + 1}, 0, sink).error().status,
            Status::volume_too_large);
  EXPECT_EQ(StoreWriter::create({1 << 20, 1 << 20, 1 << 20}, 0, sink).error().status,
            Status::volume_too_large);
  EXPECT_EQ(StoreWriter::create({5, 5, 5}, 1 << 20, sink).error().status, Status::invalid_argument);
  for (const Index3 voxels : {Index3{2, 2, 2}, Index3{8192, 8192, 8192}, Index3{1 << 20, 64, 2}}) {
    const auto log2 = choose_page_log2(voxels);
    ASSERT_TRUE(log2);
    EXPECT_LE(header_bytes_for(voxels, *log2, kMaxMetadataBytes), kMaxStoreHeaderBytes);
  }
}

TEST(Store, WriterRefusesStoresThatReadersRefuse) {
  MemorySink sink;
  auto writer = StoreWriter::create({10, 10, 10}, 100, sink);
  const std::string text = "abc";
  const auto bytes = as_bytes(text);
  const BandChunk backwards[] = {{20, 1, 1}, {15, 1, 2}};
  EXPECT_EQ(writer->add_block({10, 20}, backwards, bytes).error().status, Status::invalid_argument);
  const BandChunk gap[] = {{15, 1, 3}};
  EXPECT_EQ(
      StoreWriter::create({10, 10, 10}, 100, sink)->add_block({10, 20}, gap, bytes).error().status,
      Status::invalid_argument);
  EXPECT_EQ(StoreWriter::create({10, 10, 10}, 100, sink)->finish({}).error().status,
            Status::invalid_argument);
}

}  // namespace
}  // namespace isosplat
