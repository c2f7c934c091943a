#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>

#include "native/builder/array_source.h"
#include "native/builder/verify.h"
#include "shared/core/store/directory_page.h"
#include "shared/core/store/store_header.h"
#include "tests/native/brute_force.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

std::vector<std::byte> small_store() {
  const Index3 n{100, 70, 40};
  std::vector<uint8_t> voxels;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        voxels.push_back(static_cast<uint8_t>(
            127 + 120 * std::sin(0.2 * x) * std::sin(0.15 * y + 1) * std::cos(0.1 * z)));
      }
    }
  }
  VolumeGrid grid;
  grid.voxels = n;
  BuildOptions options;
  options.fetch_weight = 4;
  return *build_store_bytes<uint8_t>(grid, voxels, options);
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// Writes the header and pages again, so that their checksums and the content id match the chunks.
void reseal(std::vector<std::byte>& store, StoreHeader header) {
  for (PageRef& page : header.pages) {
    page.checksum = checksum32(std::span(store).subspan(page.offset, page.bytes));
  }
  header.info.content_id = {};
  ContentHash hash;
  hash.add(std::span(store).subspan(header.info.header_bytes));
  auto bytes = *write_store_header(header);
  hash.add(std::span(bytes).first(bytes.size() - 8));
  header.info.content_id = hash.digest();
  bytes = *write_store_header(header);
  std::copy(bytes.begin(), bytes.end(), store.begin());
}

/// The cells of a volume that are active at an isovalue.
uint64_t active_cells(const std::vector<uint8_t>& voxels, Index3 n, int isovalue) {
  uint64_t active = 0;
  for (int32_t z = 0; z + 1 < n.z; ++z) {
    for (int32_t y = 0; y + 1 < n.y; ++y) {
      for (int32_t x = 0; x + 1 < n.x; ++x) {
        int above = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const int32_t i = x + (corner & 1), j = y + (corner >> 1 & 1), k = z + (corner >> 2);
          above += voxels[static_cast<size_t>((k * n.y + j) * n.x + i)] > isovalue ? 1 : 0;
        }
        active += above > 0 && above < 8 ? 1 : 0;
      }
    }
  }
  return active;
}

TEST(Verify, StoresForOneIsovalueHaveItsCellsOnly) {
  std::mt19937 random(5);
  VolumeGrid grid;
  grid.voxels = {15, 12, 9};  // one level
  std::vector<uint8_t> voxels(15 * 12 * 9);
  for (uint8_t& voxel : voxels) voxel = static_cast<uint8_t>(random() % 3 == 0 ? random() : 200);
  const TemporaryFolder folder;
  for (const int isovalue : {0, 31, 127, 199, 250}) {
    BuildOptions options;
    options.only_isovalue = isovalue;
    write_file(folder.path() / "a", *build_store_bytes<uint8_t>(grid, voxels, options));
    const auto report = verify_store_file(folder.path() / "a");
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->cells, active_cells(voxels, grid.voxels, isovalue)) << isovalue;
  }
}

TEST(Verify, AcceptsStoresOfTheBuilder) {
  const TemporaryFolder folder;
  const auto store = small_store();
  write_file(folder.path() / "a", store);
  for (const unsigned threads : {1u, 3u}) {
    VerifyOptions options;
    options.threads = threads;
    double last = 0;
    options.progress = [&](double fraction) { last = fraction; };
    const auto report = verify_store_file(folder.path() / "a", options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->chunks, report->info.chunk_count);
    EXPECT_GT(report->cells, 1000u);
    EXPECT_GT(last, 0.1);
  }
}

TEST(Verify, FindsEveryFlippedByte) {
  const TemporaryFolder folder;
  const auto store = small_store();
  for (size_t at = 0; at < store.size(); at += 1 + at / 16) {
    auto bytes = store;
    bytes[at] ^= std::byte{0x10};
    write_file(folder.path() / "a", bytes);
    EXPECT_FALSE(verify_store_file(folder.path() / "a")) << at;
  }
}

TEST(Verify, FindsTruncationAndExtraBytes) {
  const TemporaryFolder folder;
  auto store = small_store();
  for (size_t size = 0; size < store.size(); size += 1 + size / 8) {
    write_file(folder.path() / "a", std::span(store).first(size));
    EXPECT_FALSE(verify_store_file(folder.path() / "a")) << size;
  }
  store.push_back({});
  write_file(folder.path() / "a", store);
  EXPECT_FALSE(verify_store_file(folder.path() / "a"));
  EXPECT_EQ(verify_store_file(folder.path() / "none").error().status, Status::io_error);
  EXPECT_EQ(verify_store_file(folder.path()).error().status, Status::io_error);
}

TEST(Verify, FindsInconsistenciesWithMatchingChecksums) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a";
  const auto store = small_store();
  const StoreHeader header = *parse_store_header(store);
  auto copy = store;
  reseal(copy, header);
  ASSERT_TRUE(copy == store);

  // Level 0's first page: its blocks, then its chunks.
  const PageRef page_ref = header.pages[header.levels[0].first_page];
  const auto with_page = [&](auto change) {
    auto bytes = store;
    DirectoryPage page = *parse_page(std::span(store).subspan(page_ref.offset, page_ref.bytes),
                                     page_ref, header.levels[0]);
    change(page, bytes);
    const auto written = write_page(page);
    std::copy(written.begin(), written.end(),
              bytes.begin() + static_cast<std::ptrdiff_t>(page_ref.offset));
    reseal(bytes, header);
    write_file(path, bytes);
    const auto report = verify_store_file(path);
    EXPECT_FALSE(report);
    return report ? Status::ok : report.error().status;
  };
  const auto rehash = [](DirectoryPage& page, std::span<std::byte> bytes, size_t block,
                         size_t band) {
    uint64_t offset = page.blocks[block].offset;
    for (size_t s = 0; s < band; ++s)
      offset += page.chunks[page.blocks[block].first_chunk + s].bytes;
    auto& chunk = page.chunks[page.blocks[block].first_chunk + band];
    chunk.checksum = checksum32(bytes.subspan(offset, chunk.bytes));
  };
  EXPECT_EQ(with_page([](DirectoryPage& page, auto&) { ++page.chunks[1].cells; }),
            Status::malformed_chunk);
  EXPECT_EQ(with_page([](DirectoryPage& page, auto&) { ++page.chunks[0].band_end; }),
            Status::malformed_chunk);
  EXPECT_NE(with_page([](DirectoryPage& page, auto&) { ++page.chunks[0].checksum; }), Status::ok);
  with_page([](DirectoryPage& page, auto&) {
    ++page.chunks[0].bytes;
    --page.chunks[1].bytes;
  });
  for (const size_t byte : {0, 1, 2, 5, 20, 100}) {
    with_page([&](DirectoryPage& page, std::vector<std::byte>& bytes) {
      bytes[page.blocks[0].offset + byte] ^= std::byte{0x21};
      rehash(page, bytes, 0, 0);
    });
  }
}

}  // namespace
}  // namespace isosplat
