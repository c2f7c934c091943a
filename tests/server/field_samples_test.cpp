// The fields of stores: their list, and their values with samples.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "native/builder/array_source.h"
#include "native/builder/store_with_fields.h"
#include "native/extract/extract.h"
#include "server/routes/router.h"
#include "shared/core/store/checksum.h"
#include "shared/core/store/directory_page.h"
#include "shared/core/store/store_header.h"
#include "shared/system/store_file/field_file.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;

constexpr Index3 kSize{90, 37, 70};  // two blocks along x and z

template <class T, class F>
std::vector<T> voxels_of(F value, Index3 size = kSize) {
  std::vector<T> voxels;
  for (int32_t z = 0; z < size.z; ++z) {
    for (int32_t y = 0; y < size.y; ++y) {
      for (int32_t x = 0; x < size.x; ++x) voxels.push_back(static_cast<T>(value(x, y, z)));
    }
  }
  return voxels;
}

/// A store with the fields "pressure", x + 2y − 3z, which is missing at x ≥ 80, and "values".
class FieldSamples : public ServerTest {
 protected:
  void SetUp() override {
    VolumeGrid grid;
    grid.voxels = kSize;
    const auto density = voxels_of<uint8_t>([](int x, int y, int z) {
      return 127 + 100 * std::sin(0.2 * x) * std::cos(0.15 * y + 0.1 * z);
    });
    const auto pressure = voxels_of<float>([](int x, int y, int z) {
      return x >= 80 ? std::numeric_limits<float>::quiet_NaN()
                     : static_cast<float>(x + 2 * y - 3 * z);
    });
    const auto input = [&](const char* name) {
      return FieldInput{name, "f.nrrd", [&]() -> Result<std::unique_ptr<VolumeSource>> {
                          return std::make_unique<ArraySource<float>>(grid, pressure, "f");
                        }};
    };
    const auto path = folder.path() / "flow.isosplat";
    ArraySource<uint8_t> source(grid, density, "density");
    const std::vector fields{input("pressure"), input("values")};
    ASSERT_TRUE(build_store_with_fields(source, fields, path, {}));
    store_ = *StoreFile::open(path);
    start();
  }

  std::string samples(const std::string& query) const {
    return "/v1/volumes/flow/" + store_->content() + "/samples?isovalue=140.25&" + query;
  }

  std::shared_ptr<StoreFile> store_;
};

TEST_F(FieldSamples, VolumeListsItsFields) {
  const Answer answer = get(port(), "/v1/volumes/flow");
  ASSERT_EQ(answer.status, 200) << answer.body;
  const Json fields = Json::parse(answer.body)["fields"];
  ASSERT_EQ(fields.size(), 2u);
  const FieldRef& pressure = store_->info().fields[0];
  EXPECT_EQ(fields[0]["name"], "pressure");
  EXPECT_EQ(fields[0]["range"], Json({-207.0, 151.0}));
  EXPECT_EQ(fields[0]["mapping"]["scale"], pressure.info.mapping.scale);
  EXPECT_EQ(fields[0]["mapping"]["hasMissing"], true);
  EXPECT_EQ(fields[0]["missingVoxels"], 10 * 37 * 70);
  EXPECT_EQ(fields[0]["offset"], pressure.offset);
  EXPECT_EQ(fields[0]["bytes"], pressure.bytes);
  EXPECT_EQ(fields[1]["name"], "values");
  EXPECT_EQ(
      get(port(), "/v1/volumes/flow", "If-None-Match: " + answer.header("etag") + "\r\n").status,
      304);
}

TEST_F(FieldSamples, HaveTheValuesOfExtract) {
  for (const uint32_t level : {0u, 1u}) {
    for (const std::string shading : {"smooth", "exact"}) {
      ExtractOptions wanted{level, 1, shading == "smooth"};
      wanted.fields = *open_fields(*store_, std::vector<std::string>{"pressure"});
      std::string expected;
      size_t missing = 0;
      const auto write = [&](const PointsWithFields& points) -> Result<void> {
        for (size_t i = 0; i < points.positions.size(); ++i) {
          const Vec3d at = points.positions[i];
          const float value = points.fields[0][i];
          missing += std::isnan(value);
          if (!std::isnan(value) && level == 0) {
            EXPECT_NEAR(value, at.x + 2 * at.y - 3 * at.z, 0.02);
          }
          const std::array<float, 4> record{static_cast<float>(at.x), static_cast<float>(at.y),
                                            static_cast<float>(at.z), value};
          expected.append(reinterpret_cast<const char*>(record.data()), sizeof record);
        }
        return {};
      };
      ASSERT_TRUE(extract_points(*store_, 140.25, {}, wanted, write));
      EXPECT_GT(missing, 10u);
      const Answer answer =
          get(port(), samples("fields=positions&format=raw&field=pressure&shading=" + shading +
                              "&level=" + std::to_string(level)));
      EXPECT_EQ(answer.status, 200) << answer.body;
      EXPECT_TRUE(answer.complete);
      EXPECT_EQ(answer.header("x-isosplat-dtype"),
                "[('positions', '<f4', (3,)), ('pressure', '<f4')]");
      EXPECT_TRUE(answer.body == expected) << level << shading;
    }
  }
}

TEST_F(FieldSamples, AreCutByABox) {
  const Answer answer =
      get(port(), samples("fields=positions&format=raw&field=pressure&box=10,5,5,70.5,30,66.5"));
  ASSERT_EQ(answer.status, 200) << answer.body;
  ASSERT_GT(answer.body.size(), 16u * 500);
  for (size_t i = 0; i < answer.body.size(); i += 16) {
    std::array<float, 4> record;
    std::memcpy(record.data(), &answer.body[i], sizeof record);
    ASSERT_NEAR(record[3], record[0] + 2 * record[1] - 3 * record[2], 0.02);
  }
}

TEST_F(FieldSamples, AreOneArrayOfNumPy) {
  const Answer answer = get(port(), samples("fields=values&field=values"));
  EXPECT_NE(answer.body.substr(0, 200).find("[('values', '<f4'), ('values_field', '<f4')]"),
            std::string::npos);
}

TEST_F(FieldSamples, RefuseUnknownFields) {
  const Answer answer = get(port(), samples("field=speed"));
  EXPECT_EQ(answer.status, 404);
  EXPECT_NE(answer.body.find("pressure, values"), std::string::npos) << answer.body;
}

/// A store whose level 0 has two pages of blocks. A list of blocks in raster order returns from the
/// second page to the first one. All blocks have cells of the isosurface y = 0.5025. The field
/// "noise" has larger chunks than the store.
class FieldSamplesOfPages : public ServerTest {
 protected:
  void SetUp() override {
    VolumeGrid grid;
    grid.voxels = {258, 3, 67};
    // The voxel with the value 1 keeps the step of quantization at 1.
    const auto density = voxels_of<uint8_t>(
        [](int x, int y, int z) { return x + y + z == 0 ? 1 : 100 * y; }, grid.voxels);
    std::mt19937 random(5);
    const auto noise = voxels_of<uint16_t>([&](int, int, int) { return random(); }, grid.voxels);
    const std::vector fields{
        FieldInput{"noise", "n.nrrd", [&]() -> Result<std::unique_ptr<VolumeSource>> {
                     return std::make_unique<ArraySource<uint16_t>>(grid, noise, "n");
                   }}};
    const auto path = folder.path() / "flat.isosplat";
    ArraySource<uint8_t> source(grid, density, "density");
    ASSERT_TRUE(build_store_with_fields(source, fields, path, {}));
    store_ = *StoreFile::open(path);
    isovalue_ = store_->info().mapping.quantized_isovalue(50.25);
    selection_ = *store_->chunks_for(0, isovalue_, isovalue_);
    ASSERT_EQ(selection_.count, 10u);
    size_t pages = 0;
    for (const PageRef& page : store_->pages()) pages += page.level == 0;
    ASSERT_EQ(pages, 2u);
  }

  Answer samples(const std::string& query) {
    return get(port(), "/v1/volumes/flat/" + store_->content() +
                           "/samples?fields=positions&format=raw&isovalue=50.25" + query);
  }

  std::shared_ptr<StoreFile> store_;
  float isovalue_ = 0;        ///< quantized
  ChunkSelection selection_;  ///< the chunks of the isosurface
};

TEST_F(FieldSamplesOfPages, CountEachPageOnce) {
  options.limits.query_directory_bytes = selection_.directory_bytes;
  start();
  EXPECT_EQ(samples("").status, 200);
  const Answer with_field = samples("&field=noise");
  EXPECT_EQ(with_field.status, 200) << with_field.body;
  EXPECT_EQ(with_field.body.size(), 16u * 257 * 66);
}

TEST_F(FieldSamplesOfPages, BeyondALimitNameAllLimits) {
  options.limits.query_bytes = selection_.bytes;
  start();
  EXPECT_EQ(samples("").status, 200);
  const Answer refused = samples("&field=noise");
  EXPECT_EQ(refused.status, 413);
  const std::string expected = fmt::format(
      "expected at most {} bytes of chunks, 65536 chunks and 268435456 bytes of directory pages of "
      "the field 'noise', found at least ",
      selection_.bytes);
  EXPECT_NE(refused.body.find(expected), std::string::npos) << refused.body;
}

TEST_F(FieldSamplesOfPages, RefuseAFieldWithOtherBlocks) {
  std::vector<std::byte> file(store_->info().file_bytes);
  ASSERT_TRUE(store_->read(0, file));
  const FieldRef ref = store_->info().fields[0];
  const auto field = std::span(file).subspan(ref.offset, ref.bytes);
  StoreHeader header = *parse_store_header(field);
  for (PageRef& page : header.pages) {
    if (page.level > 0) continue;
    const auto place = field.subspan(page.offset, page.bytes);
    DirectoryPage changed = *parse_page(place, page, header.levels[0]);
    changed.blocks[0].interval.min = 60;  // above the isovalue
    const auto bytes = write_page(changed);
    ASSERT_EQ(bytes.size(), page.bytes);
    std::ranges::copy(bytes, place.begin());
    page.checksum = checksum32(bytes);
  }
  std::ranges::copy(*write_store_header(header), field.begin());
  write_file(folder.path() / "flat.isosplat", file);
  start();
  EXPECT_EQ(samples("").status, 200);
  const Answer refused = samples("&field=noise");
  EXPECT_EQ(refused.status, 500);
  EXPECT_EQ(Json::parse(refused.body)["status"], "malformed_page");
  EXPECT_NE(refused.body.find("flat.isosplat, field 'noise': expected chunk "), std::string::npos)
      << refused.body;
}

TEST_F(FieldSamplesOfPages, CountTheMemoryOfTheField) {
  const auto ignore = [](std::string_view) {};
  Catalog catalog({folder.path()}, ignore);
  StorePool stores({}, ignore);
  ScenePool scenes({}, ScenePool::OutsideLinks::followed, ignore);
  catalog.scan();
  const auto memory_with = [&](const std::string& query) {
    const std::string target = "/v1/volumes/flat/" + store_->content() +
                               "/samples?fields=positions&isovalue=50.25" + query;
    Request request;
    request.method = Method::get;
    request.target = target;
    const Response response = Router(catalog, stores, scenes, {}).respond(request);
    return response.stream ? response.stream->memory() : 0;
  };
  const uint64_t without = memory_with("");
  EXPECT_GT(without, 0u);
  const auto field = *open_field(*store_, 0);
  const auto of_field = *field->chunks_for(0, isovalue_, isovalue_);
  uint32_t largest = 0, cells = 0;
  for (const ChunkRef& chunk : of_field.chunks) {
    largest = std::max(largest, chunk.bytes);
    cells = std::max(cells, chunk.cells);
  }
  EXPECT_EQ(memory_with("&field=noise") - without,
            of_field.directory_bytes + field->header().size() + largest + sizeof(float) * cells);
}

}  // namespace
}  // namespace isosplat::server::test
