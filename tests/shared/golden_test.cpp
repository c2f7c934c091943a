#include <gtest/gtest.h>

#include <fstream>

#include "shared/core/store/store_reader.h"
#include "tests/golden/digest.h"

namespace isosplat {
namespace {

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

constexpr const char* kStores[] = {"v1.0/tiny",        "v1.0/u8",  "v1.0/i16",
                                   "v1.0/f32_missing", "v1.0/u32", "v1.1/fields"};

TEST(Golden, StoresOfEveryVersionDecodeToTheSameValues) {
  for (const std::string name : kStores) {
    SCOPED_TRACE(name);
    const std::string path = std::string(ISOSPLAT_GOLDEN) + "/" + name;
    const std::string store = content(path + ".isosplat");
    ASSERT_FALSE(store.empty());
    EXPECT_EQ(digest_of(std::as_bytes(std::span(store.data(), store.size()))),
              content(path + ".txt"));
  }
}

/// Reads the header and all pages. Returns the status of the first one that is refused.
Status open_directory(std::span<const std::byte> store, StoreKind kind = StoreKind::store) {
  auto reader = StoreReader::open(store, kind);
  if (!reader) return reader.error().status;
  for (uint32_t i = 0; i < reader->pages().size(); ++i) {
    const PageRef page = reader->pages()[i];
    const size_t begin = std::min<size_t>(page.offset, store.size());
    const size_t size = std::min<size_t>(page.bytes, store.size() - begin);
    if (auto added = reader->add_page(i, store.subspan(begin, size)); !added) {
      return added.error().status;
    }
  }
  return Status::ok;
}

/// Calls f(bytes, kind) for each golden store, and for each field of one.
template <class F>
void for_each_store(F f) {
  for (const std::string name : kStores) {
    SCOPED_TRACE(name);
    const std::string store = content(std::string(ISOSPLAT_GOLDEN) + "/" + name + ".isosplat");
    ASSERT_FALSE(store.empty());
    const auto bytes = std::as_bytes(std::span(store.data(), store.size()));
    f(std::vector(bytes.begin(), bytes.end()), StoreKind::store);
    const auto reader = StoreReader::open(bytes);
    ASSERT_TRUE(reader);
    for (const FieldRef& field : reader->info().fields) {
      const auto of_field = bytes.subspan(field.offset, field.bytes);
      f(std::vector(of_field.begin(), of_field.end()), StoreKind::field);
    }
  }
}

TEST(Golden, EveryTruncationIsRefused) {
  for_each_store([](const std::vector<std::byte>& store, StoreKind kind) {
    ASSERT_EQ(open_directory(store, kind), Status::ok);
    for (size_t size = 0; size < store.size(); ++size) {
      // The last page ends with the store.
      ASSERT_EQ(open_directory(std::span(store).first(size), kind),
                size < 8 ? Status::not_a_store : Status::truncated)
          << size;
    }
  });
}

TEST(Golden, EveryFlippedBitOfHeaderAndDirectoryIsRefused) {
  for_each_store([](std::vector<std::byte> store, StoreKind kind) {
    const auto reader = StoreReader::open(store, kind);
    ASSERT_TRUE(reader);
    std::vector<std::pair<size_t, size_t>> parts{{0, reader->info().header_bytes}};
    for (const PageRef& page : reader->pages()) parts.emplace_back(page.offset, page.bytes);
    for (const auto& [begin, size] : parts) {
      for (size_t bit = 8 * begin; bit < 8 * (begin + size); ++bit) {
        store[bit / 8] ^= std::byte{1} << (bit % 8);
        ASSERT_NE(open_directory(store, kind), Status::ok) << bit;
        store[bit / 8] ^= std::byte{1} << (bit % 8);
      }
    }
  });
}

}  // namespace
}  // namespace isosplat
