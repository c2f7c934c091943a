#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "shared/core/store/checksum.h"
#include "shared/core/store/field_sections.h"
#include "shared/core/store/store_header.h"
#include "tests/shared/store_fixture.h"

namespace isosplat {
namespace {

constexpr uint64_t kFieldBytes = 1000;

FieldRef field_named(const std::string& name) {
  FieldRef field;
  field.info.name = name;
  field.info.mapping = {-20, 0.5, 0.25, 16, true};
  field.info.range = {3, 60000};
  field.info.missing_voxels = 7;
  field.bytes = kFieldBytes;
  return field;
}

StoreHeader plain_header() {
  constexpr Index3 kVoxels{70, 9, 6};
  const auto levels = fixture::make_levels(kVoxels, [&](int32_t x, int32_t y, int32_t z) {
    return fixture::rough_ball(kVoxels, x, y, z);
  });
  return *parse_store_header(fixture::make_store(levels, 40));
}

/// The header of a store with these fields, which lie before its chunks.
StoreHeader with_fields(std::vector<FieldRef> fields) {
  StoreHeader header = plain_header();
  header.info.fields = std::move(fields);
  uint64_t moved = field_sections_bytes(header.info);
  header.info.header_bytes += static_cast<uint32_t>(moved);
  for (const FieldRef& field : header.info.fields) moved += field.bytes;
  header.info.file_bytes += moved;
  for (LevelRef& level : header.levels) level.chunks_offset += moved;
  return header;
}

Status status_of(const StoreHeader& header) {
  const auto bytes = write_store_header(header);
  if (!bytes) return bytes.error().status;
  const auto reader = StoreReader::open(*bytes);
  return reader ? Status::ok : reader.error().status;
}

TEST(StoreFields, AreListedBeforeTheChunks) {
  const StoreHeader header = with_fields({field_named("temperature"), field_named("p_2.x-y")});
  const auto reader = StoreReader::open(*write_store_header(header));
  ASSERT_TRUE(reader) << reader.error().message;
  const StoreInfo& info = reader->info();
  ASSERT_EQ(info.fields.size(), 2u);
  const FieldInfo& first = info.fields[0].info;
  EXPECT_EQ(first.name, "temperature");
  EXPECT_EQ(first.mapping.offset, -20);
  EXPECT_EQ(first.mapping.scale, 0.5);
  EXPECT_EQ(first.mapping.max_error, 0.25);
  EXPECT_EQ(first.mapping.bits, 16);
  EXPECT_TRUE(first.mapping.has_missing);
  EXPECT_EQ(first.range, (CellInterval{3, 60000}));
  EXPECT_EQ(first.missing_voxels, 7u);
  EXPECT_EQ(info.fields[0].offset, info.header_bytes);
  EXPECT_EQ(info.fields[1].offset, info.header_bytes + kFieldBytes);
  EXPECT_EQ(reader->levels()[0].chunks_offset, info.header_bytes + 2 * kFieldBytes);
  EXPECT_EQ(reader->levels()[0].chunks_bytes, plain_header().levels[0].chunks_bytes);
  EXPECT_EQ(reader->bootstrap_range().offset, reader->levels()[0].chunks_offset);
}

TEST(StoreFields, InvalidListsAreRefused) {
  const auto with = [](auto change) {
    FieldRef field = field_named("f");
    change(field);
    return status_of(with_fields({field}));
  };
  EXPECT_EQ(with([](FieldRef&) {}), Status::ok);
  for (const std::string name : {"", "7", "_a", "a b", "a/b", "a\n", "\xc3\xa9"}) {
    EXPECT_EQ(with([&](FieldRef& field) { field.info.name = name; }), Status::malformed_header);
  }
  EXPECT_EQ(with([&](FieldRef& field) { field.info.name.assign(65, 'a'); }),
            Status::malformed_header);
  EXPECT_EQ(with([](FieldRef& field) { field.info.mapping.scale = 0; }), Status::malformed_header);
  EXPECT_EQ(with([](FieldRef& field) { field.info.mapping.offset = INFINITY; }),
            Status::malformed_header);
  EXPECT_EQ(with([](FieldRef& field) { field.info.mapping.max_error = -1; }),
            Status::malformed_header);
  EXPECT_EQ(with([](FieldRef& field) { field.info.mapping.bits = 12; }), Status::malformed_header);
  EXPECT_EQ(with([](FieldRef& field) { field.info.mapping.bits = 8; }), Status::malformed_header);
  EXPECT_EQ(with([](FieldRef& field) { field.info.range = {5, 4}; }), Status::malformed_header);
  EXPECT_EQ(with([](FieldRef& field) { field.info.mapping.has_missing = false; }),
            Status::malformed_header);
  EXPECT_EQ(status_of(with_fields({field_named("a"), field_named("a")})), Status::malformed_header);
  EXPECT_EQ(status_of(with_fields(std::vector(17, field_named("a")))), Status::malformed_header);
}

TEST(StoreFields, SizesBeyondTheFileAreRefused) {
  for (const uint64_t bytes :
       {uint64_t{1} << 20, uint64_t{1} << 47, UINT64_MAX, UINT64_MAX - 5000}) {
    StoreHeader header = with_fields({field_named("a"), field_named("b")});
    // The levels state the sizes as before, so that only the list of fields is wrong.
    auto written = *write_store_header(header);
    const auto at =
        std::search(written.begin(), written.end(), std::begin("flds"), std::begin("flds") + 4,
                    [](std::byte a, char b) { return a == std::byte(b); });
    ASSERT_NE(at, written.end());
    write_le(&*at + 16, 8, bytes);
    const size_t hashed = written.size() - 8;
    write_le(written.data() + hashed, 8, checksum64(std::span(written).first(hashed)));
    const auto reader = StoreReader::open(written);
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error().status, Status::malformed_header) << bytes;
  }
}

TEST(StoreFields, HaveNoFieldsThemselves) {
  for (const bool is_nested : {false, true}) {
    StoreHeader header = is_nested ? with_fields({field_named("a")}) : plain_header();
    const size_t before = field_sections_bytes(header.info);
    header.info.field = field_named("own").info;
    const uint64_t moved = field_sections_bytes(header.info) - before;
    header.info.header_bytes += static_cast<uint32_t>(moved);
    header.info.file_bytes += moved;
    for (LevelRef& level : header.levels) level.chunks_offset += moved;
    const auto bytes = *write_store_header(header);
    EXPECT_EQ(StoreReader::open(bytes).error().status, Status::not_a_store);
    const auto field = StoreReader::open(bytes, StoreKind::field);
    EXPECT_EQ(field.has_value(), !is_nested);
    if (!field) {
      EXPECT_EQ(field.error().status, Status::malformed_header);
    }
  }
}

TEST(StoreFields, ChangeNothingInHeadersWithoutThem) {
  EXPECT_EQ(field_sections_bytes(plain_header().info), 0u);
  const auto bytes = *write_store_header(plain_header());
  EXPECT_EQ(read_le(bytes.data() + 10, 2), 0u);  // minor
  EXPECT_EQ(read_le(write_store_header(with_fields({field_named("a")}))->data() + 10, 2), 1u);
}

}  // namespace
}  // namespace isosplat
