#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <mutex>
#include <random>

#include "native/builder/array_source.h"
#include "native/builder/field_build.h"
#include "native/builder/store_with_fields.h"
#include "native/builder/verify.h"
#include "shared/core/store/field_sections.h"
#include "shared/core/store/store_header.h"
#include "shared/system/store_file/field_file.h"
#include "tests/native/brute_force.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

constexpr Index3 kSize{90, 37, 70};  // two blocks along x and z, four levels

template <class T, class F>
std::vector<T> voxels_of(Index3 n, F value) {
  std::vector<T> voxels;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) voxels.push_back(static_cast<T>(value(x, y, z)));
    }
  }
  return voxels;
}

std::vector<uint8_t> density(Index3 n = kSize) {
  return voxels_of<uint8_t>(n, [](int x, int y, int z) {
    return 127 + 100 * std::sin(0.2 * x) * std::cos(0.15 * y + 0.1 * z);
  });
}

template <class T>
FieldInput input(const std::string& name, Index3 n, const std::vector<T>& voxels, double slope = 1,
                 double intercept = 0) {
  return {name, name + ".nrrd", [=, &voxels]() -> Result<std::unique_ptr<VolumeSource>> {
            VolumeGrid grid;
            grid.voxels = n;
            return std::make_unique<ArraySource<T>>(grid, voxels, name, slope, intercept);
          }};
}

Result<BuildReport> build(const std::filesystem::path& target, std::span<const FieldInput> fields,
                          const BuildOptions& options = {}) {
  VolumeGrid grid;
  grid.voxels = kSize;
  const auto voxels = density();
  ArraySource<uint8_t> source(grid, voxels, "density");
  return build_store_with_fields(source, fields, target, options);
}

std::vector<std::byte> content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// Compares the field's values at the corners of all cells of all chunks with the reduced field.
template <class T>
void expect_values(const StoreFile& store, size_t number, const std::vector<T>& values,
                   double slope = 1, double intercept = 0) {
  const auto field = open_field(store, number);
  ASSERT_TRUE(field) << field.error().message;
  const FieldInfo& info = *(*field)->info().field;
  std::vector<double> in_units;
  for (const T value : values) in_units.push_back(intercept + slope * static_cast<double>(value));
  PlainLevel level = plain_level_0(kSize, in_units, info.mapping);
  for (size_t i = 0; i < in_units.size(); ++i) {
    if (level.voxels[i] < 0) continue;
    ASSERT_LE(std::abs(info.mapping.value(level.voxels[i]) - in_units[i]),
              info.mapping.max_error * 1.001 + 1e-12 * std::abs(in_units[i]));
  }
  uint64_t chunks = 0;
  ChunkDecoder decoder;
  DecodedCells cells;
  std::vector<CellCorners> corners;
  for (uint32_t l = 0; l < store.info().levels; ++l) {
    if (l > 0) level = plain_coarser(level);
    const LevelGrid grid = level_grid(kSize, l);
    const auto selection = store.chunks_for(l, 0, 65535);
    ASSERT_TRUE(selection);
    for (const ChunkRef& chunk : selection->chunks) {
      const Index3 block = chunk.block.index;
      const ChunkShape shape{block_cells(grid, block), chunk.band_begin, chunk.band_end,
                             chunk.cells, l > 0};
      std::vector<std::byte> bytes;
      ASSERT_TRUE(store.read_chunk(chunk, bytes));
      ASSERT_TRUE(decoder.decode(bytes, shape, cells));
      bytes.clear();
      ASSERT_TRUE((*field)->read_chunk(*(*field)->chunk(chunk.block, chunk.band), bytes));
      const auto decoded = decoder.decode_field(bytes, shape.block_cells, cells.cell,
                                                1u << info.mapping.bits, corners);
      ASSERT_TRUE(decoded) << decoded.error().message;
      for (size_t i = 0; i < corners.size(); ++i) {
        const auto c = static_cast<int32_t>(cells.cell[i]);
        for (int32_t k = 0; k < 8; ++k) {
          const int32_t expected =
              level.voxels[level.voxel_at(block.x * kBlockCells + (c & 63) + (k & 1),
                                          block.y * kBlockCells + (c >> 6 & 63) + (k >> 1 & 1),
                                          block.z * kBlockCells + (c >> 12) + (k >> 2))];
          ASSERT_EQ(corners[i][static_cast<size_t>(k)], expected < 0 ? kMissingVoxel : expected);
        }
      }
      ++chunks;
    }
  }
  EXPECT_EQ(chunks, store.info().chunk_count);
}

TEST(BuildFields, StoresTheValuesAtAllCornersOfAllLevels) {
  const TemporaryFolder folder;
  std::mt19937 random(7);
  const auto bytes = voxels_of<uint8_t>(
      kSize, [](int x, int y, int z) { return 100 + 50 * std::cos(0.05 * x) + y + 0.4 * z; });
  const auto shorts =
      voxels_of<int16_t>(kSize, [&](int, int, int) { return static_cast<int>(random()) % 32768; });
  const auto floats = voxels_of<float>(kSize, [&](int x, int y, int z) {
    return random() % 40 == 0 || x > 80 ? std::numeric_limits<double>::quiet_NaN()
                                        : 1e-3 * std::sin(0.1 * x + 0.2 * y) * z;
  });
  const std::vector fields{input("small", kSize, bytes), input("scaled", kSize, shorts, 0.5, -3),
                           input("real", kSize, floats)};
  const auto report = build(folder.path() / "a", fields);
  ASSERT_TRUE(report) << report.error().message;
  const auto store = StoreFile::open(folder.path() / "a");
  ASSERT_TRUE(store) << store.error().message;
  const auto& listed = (*store)->info().fields;
  ASSERT_EQ(listed.size(), 3u);
  EXPECT_EQ(listed[0].info.mapping.bits, 8);
  EXPECT_EQ(listed[0].info.mapping.max_error, 0);
  EXPECT_EQ(listed[1].info.mapping.max_error, 0);
  EXPECT_EQ(listed[1].info.mapping.scale, 0.5);
  EXPECT_GT(listed[2].info.mapping.max_error, 0);
  EXPECT_EQ(listed[2].info.missing_voxels,
            static_cast<uint64_t>(std::count_if(floats.begin(), floats.end(),
                                                [](float v) { return std::isnan(v); })));
  expect_values(**store, 0, bytes);
  expect_values(**store, 1, shorts, 0.5, -3);
  expect_values(**store, 2, floats);
  const auto verified = verify_store_file(folder.path() / "a");
  ASSERT_TRUE(verified) << verified.error().message;
  EXPECT_EQ(verified->field_chunks, 3 * verified->chunks);
}

TEST(BuildFields, LeavesTheChunksOfTheStoreAsTheyAre) {
  const TemporaryFolder folder;
  const auto field = density();
  ASSERT_TRUE(build(folder.path() / "a", std::vector{input("same", kSize, field)}));
  ASSERT_TRUE(build(folder.path() / "b", {}));
  const auto with = content(folder.path() / "a"), without = content(folder.path() / "b");
  VolumeGrid grid;
  grid.voxels = kSize;
  ASSERT_TRUE(build_store_file<uint8_t>(grid, field, folder.path() / "density"));
  EXPECT_TRUE(without == content(folder.path() / "density"));
  const StoreReader a = open_whole(with), b = open_whole(without);
  EXPECT_TRUE(b.info().fields.empty());
  for (uint32_t l = 0; l < a.info().levels; ++l) {
    const auto of_a = *a.chunks_for(l, 0, 65535), of_b = *b.chunks_for(l, 0, 65535);
    ASSERT_EQ(of_a.size(), of_b.size());
    for (size_t i = 0; i < of_a.size(); ++i) {
      ASSERT_EQ(of_a[i].checksum, of_b[i].checksum);
      ASSERT_EQ(of_a[i].offset - a.levels()[0].chunks_offset,
                of_b[i].offset - b.levels()[0].chunks_offset);
    }
  }
  // What a viewer reads first has no bytes of the field.
  EXPECT_EQ(a.bootstrap_range().bytes, b.bootstrap_range().bytes);
  expect_store_of(with, kSize, field);
}

TEST(BuildFields, WritesTheSameBytesWithAnyThreadsAndMemory) {
  const TemporaryFolder folder;
  const auto field = voxels_of<int16_t>(kSize, [](int x, int y, int z) { return x * y - 7 * z; });
  const std::vector fields{input("f", kSize, field)};
  BuildOptions options;
  options.threads = 1;
  ASSERT_TRUE(build(folder.path() / "a", fields, options));
  const auto expected = content(folder.path() / "a");
  options.threads = 3;
  ASSERT_TRUE(build(folder.path() / "a", fields, options));
  EXPECT_TRUE(content(folder.path() / "a") == expected);
  options.threads = 1;
  options.memory_bytes = uint64_t{72} << 20;
  const auto built = build(folder.path() / "a", fields, options);
  ASSERT_TRUE(built) << built.error().message;
  EXPECT_TRUE(content(folder.path() / "a") == expected);
}

TEST(BuildFields, ProgressNeverReturns) {
  const TemporaryFolder folder;
  const auto field = density();
  std::mutex mutex;
  std::vector<BuildProgress> reported;
  BuildOptions options;
  options.progress = [&](const BuildProgress& progress) {
    const std::lock_guard lock(mutex);
    reported.push_back(progress);
  };
  const std::vector fields{input("f", kSize, field), input("g", kSize, field)};
  ASSERT_TRUE(build(folder.path() / "a", fields, options));
  // A machine that builds in less than 50 ms reports nothing.
  for (size_t i = 1; i < reported.size(); ++i) {
    ASSERT_GE(reported[i].fraction, reported[i - 1].fraction) << reported[i].phase;
    ASSERT_GE(reported[i].seconds_left, 0);
  }
  for (const BuildProgress& progress : reported) EXPECT_LE(progress.fraction, 1);
}

TEST(BuildFields, RefusesOtherGridsAndNames) {
  const TemporaryFolder folder;
  const auto field = density();
  const auto small = density({20, 20, 20});
  const auto refused = [&](const std::vector<FieldInput>& fields) {
    const auto built = build(folder.path() / "a", fields);
    EXPECT_FALSE(built);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "a"));
    return built ? Error{} : built.error();
  };
  const Error other = refused({input("f", {20, 20, 20}, small)});
  EXPECT_EQ(other.status, Status::invalid_argument);
  EXPECT_NE(other.message.find("expected 90 × 37 × 70 voxels"), std::string::npos) << other.message;
  for (const std::string name : {"", "7up", "a b", "a/b", "é"}) {
    EXPECT_EQ(refused({input(name, kSize, field)}).status, Status::invalid_argument) << name;
  }
  EXPECT_EQ(refused({input(std::string(65, 'a'), kSize, field)}).status, Status::invalid_argument);
  EXPECT_EQ(refused({input("f", kSize, field), input("f", kSize, field)}).status,
            Status::invalid_argument);
}

TEST(BuildFields, FieldsOpenAsFieldsOnly) {
  const TemporaryFolder folder;
  const auto field = density();
  ASSERT_TRUE(build(folder.path() / "a", std::vector{input("f", kSize, field)}));
  const auto store = StoreFile::open(folder.path() / "a");
  ASSERT_TRUE(store);
  EXPECT_EQ(*find_field((*store)->info(), "f"), 0u);
  EXPECT_EQ(find_field((*store)->info(), "g").error().status, Status::not_found);
  const FieldRef ref = (*store)->info().fields[0];
  const auto bytes = content(folder.path() / "a");
  const auto of_field = std::span(bytes).subspan(ref.offset, ref.bytes);
  EXPECT_EQ(StoreReader::open(of_field).error().status, Status::not_a_store);
  EXPECT_TRUE(StoreReader::open(of_field, StoreKind::field));
  EXPECT_EQ(StoreReader::open(bytes, StoreKind::field).error().status, Status::malformed_header);
  // Without memory for pages, the last one that was used is kept.
  const auto opened = *open_field(**store, 0, /*directory_bytes=*/1);
  for (uint32_t l = 0; l < 4; ++l) ASSERT_TRUE(opened->chunks_for(l, 0, 65535));
  EXPECT_EQ(opened->directory_bytes(), opened->pages().front().bytes);
}

/// Writes the header again, so that its checksum and the content id match it.
void reseal(std::vector<std::byte>& store, StoreHeader header) {
  header.info.content_id = {};
  ContentHash hash;
  hash.add(std::span(store).subspan(header.info.header_bytes));
  auto bytes = *write_store_header(header);
  hash.add(std::span(bytes).first(bytes.size() - 8));
  header.info.content_id = hash.digest();
  bytes = *write_store_header(header);
  std::copy(bytes.begin(), bytes.end(), store.begin());
}

TEST(BuildFields, OpenFieldRefusesWhatTheStoreDoesNotDescribe) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a";
  const auto field = voxels_of<uint8_t>(kSize, [](int x, int y, int) { return 10 + x + y; });
  ASSERT_TRUE(build(path, std::vector{input("f", kSize, field)}));
  const auto store = content(path);
  const StoreHeader header = *parse_store_header(store);
  const FieldRef ref = header.info.fields[0];
  const auto expect_refused = [&](std::span<const std::byte> bytes) {
    write_file(path, bytes);
    const auto opened = StoreFile::open(path);
    ASSERT_TRUE(opened) << opened.error().message;
    const auto refused = open_field(**opened, 0);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().status, Status::malformed_header);
    EXPECT_NE(refused.error().message.find(", field '"), std::string::npos)
        << refused.error().message;
  };
  const auto changed_list = [&](auto change) {
    auto bytes = store;
    StoreHeader other = header;
    change(other.info.fields[0].info);
    reseal(bytes, other);
    expect_refused(bytes);
  };
  changed_list([](FieldInfo& info) { info.name = "g"; });
  changed_list([](FieldInfo& info) { --info.range.max; });
  changed_list([](FieldInfo& info) { info.mapping.scale *= 2; });
  changed_list([](FieldInfo& info) { info.mapping.max_error = 1; });
  const auto changed_field = [&](auto change) {
    auto bytes = store;
    const auto of_field = std::span(bytes).subspan(ref.offset, ref.bytes);
    StoreHeader inner = *parse_store_header(of_field);
    change(inner);
    std::vector<std::byte> other(of_field.begin(), of_field.end());
    reseal(other, inner);
    std::copy(other.begin(), other.end(), of_field.begin());
    reseal(bytes, header);
    expect_refused(bytes);
  };
  changed_field([](StoreHeader& inner) { inner.info.mapping.scale *= 2; });
  changed_field([](StoreHeader& inner) { inner.info.mapping.has_missing = true; });
  changed_field([](StoreHeader& inner) { ++inner.pages.back().interval.min; });
}

TEST(BuildFields, MessagesNameTheField) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a";
  const auto voxels = density();
  ASSERT_TRUE(build(path, std::vector{input("f", kSize, voxels)}));
  auto bytes = content(path);
  const FieldRef ref = parse_store_header(bytes)->info.fields[0];
  const ChunkRef chunk = *(*open_field(**StoreFile::open(path), 0))->chunk({0, {0, 0, 0}}, 0);
  bytes[ref.offset + chunk.offset] ^= std::byte{1};
  write_file(path, bytes);
  const auto field = *open_field(**StoreFile::open(path), 0);
  std::vector<std::byte> read;
  const auto damaged = field->read_chunk(chunk, read);
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().status, Status::checksum_mismatch);
  EXPECT_EQ(damaged.error().message.rfind("a, field 'f': chunk ", 0), 0u)
      << damaged.error().message;
}

TEST(BuildFields, VerifyFindsDamageAndInconsistencies) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a";
  const auto field = voxels_of<uint8_t>(kSize, [](int x, int y, int) { return 10 + x + y; });
  ASSERT_TRUE(build(path, std::vector{input("f", kSize, field)}));
  const auto store = content(path);
  const StoreHeader header = *parse_store_header(store);
  const FieldRef ref = header.info.fields[0];
  for (uint64_t at = 0; at < ref.bytes; at += 1 + at / 4) {
    auto bytes = store;
    bytes[ref.offset + at] ^= std::byte{0x10};
    write_file(path, bytes);
    EXPECT_FALSE(verify_store_file(path)) << at;
  }
  // The same with a content id that matches.
  for (uint64_t at = 0; at < ref.bytes; at += 1 + at / 2) {
    auto bytes = store;
    bytes[ref.offset + at] ^= std::byte{0x10};
    reseal(bytes, header);
    write_file(path, bytes);
    EXPECT_FALSE(verify_store_file(path)) << at;
  }
  const auto changed = [&](auto change) {
    auto bytes = store;
    StoreHeader other = header;
    change(other.info.fields[0].info);
    reseal(bytes, other);
    write_file(path, bytes);
    const auto verified = verify_store_file(path);
    EXPECT_FALSE(verified);
    return verified ? Status::ok : verified.error().status;
  };
  EXPECT_EQ(changed([](FieldInfo& info) { info.name = "g"; }), Status::malformed_header);
  EXPECT_EQ(changed([](FieldInfo& info) { --info.range.max; }), Status::malformed_header);
  // A range in both headers that does not have all values.
  auto bytes = store;
  const auto of_field = std::span(bytes).subspan(ref.offset, ref.bytes);
  StoreHeader inner = *parse_store_header(of_field);
  --inner.info.field->range.max;
  std::vector<std::byte> narrowed(of_field.begin(), of_field.end());
  reseal(narrowed, inner);
  std::copy(narrowed.begin(), narrowed.end(), of_field.begin());
  StoreHeader outer = header;
  --outer.info.fields[0].info.range.max;
  reseal(bytes, outer);
  write_file(path, bytes);
  EXPECT_EQ(verify_store_file(path).error().status, Status::malformed_chunk);
}

}  // namespace
}  // namespace isosplat
