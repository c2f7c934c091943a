// The fields of stores: their list, and their values with samples.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "native/builder/array_source.h"
#include "native/builder/store_with_fields.h"
#include "native/extract/extract.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;

constexpr Index3 kSize{90, 37, 70};  // two blocks along x and z

template <class T, class F>
std::vector<T> voxels_of(F value) {
  std::vector<T> voxels;
  for (int32_t z = 0; z < kSize.z; ++z) {
    for (int32_t y = 0; y < kSize.y; ++y) {
      for (int32_t x = 0; x < kSize.x; ++x) voxels.push_back(static_cast<T>(value(x, y, z)));
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

}  // namespace
}  // namespace isosplat::server::test
