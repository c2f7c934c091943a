// Points as arrays, and tables of isovalues: against extraction and brute force.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "native/builder/array_source.h"
#include "native/extract/extract.h"
#include "server/routes/router.h"
#include "shared/core/points/position_precision.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;

constexpr double kIsovalue = 60.5;

/// A store of several blocks, on a sheared grid away from the origin.
VolumeGrid small_grid() {
  VolumeGrid grid;
  grid.voxels = {150, 90, 80};
  grid.spacing = {1, 1.5, 2};
  grid.origin = {-100, 50, 25};
  const double c = std::cos(0.3), s = std::sin(0.3);
  grid.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
  return grid;
}

uint8_t voxel(int32_t x, int32_t y, int32_t z) {
  return static_cast<uint8_t>((x * x + 2 * y * y + 3 * z * z) >> 7);
}

double interpolated(Vec3d at) {
  const Vec3d low{std::floor(at.x), std::floor(at.y), std::floor(at.z)}, part = at - low;
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const double weight =
        (dx ? part.x : 1 - part.x) * (dy ? part.y : 1 - part.y) * (dz ? part.z : 1 - part.z);
    sum += weight * voxel(int32_t(low.x) + dx, int32_t(low.y) + dy, int32_t(low.z) + dz);
  }
  return sum;
}

Result<void> build(const VolumeGrid& grid, const std::filesystem::path& path) {
  std::vector<uint8_t> voxels;
  for (int32_t z = 0; z < grid.voxels.z; ++z) {
    for (int32_t y = 0; y < grid.voxels.y; ++y) {
      for (int32_t x = 0; x < grid.voxels.x; ++x) {
        voxels.push_back(voxel(x, y, z));
      }
    }
  }
  auto built = build_store_file<uint8_t>(grid, voxels, path);
  if (!built) return tl::unexpected(built.error());
  return {};
}

PointArrays extracted(const StoreFile& store, uint32_t level, bool smooth) {
  PointArrays all;
  ProjectionOptions projection;
  projection.values = true;
  const auto count = extract_points(
      store, kIsovalue, projection, {level, 1, smooth}, [&](const PointArrays& some) {
        all.positions.insert(all.positions.end(), some.positions.begin(), some.positions.end());
        all.normals.insert(all.normals.end(), some.normals.begin(), some.normals.end());
        all.values.insert(all.values.end(), some.values.begin(), some.values.end());
        return Result<void>{};
      });
  EXPECT_TRUE(count);
  return all;
}

template <class T>
void append(std::string& bytes, std::initializer_list<T> numbers) {
  for (const T number : numbers) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
}

/// Records of positions in single precision, normals and values.
std::string records_of(const PointArrays& points) {
  std::string bytes;
  for (size_t i = 0; i < points.positions.size(); ++i) {
    const Vec3d p = points.positions[i];
    const Vec3f n = points.normals[i];
    append(bytes, {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), n.x,
                   n.y, n.z, points.values[i]});
  }
  return bytes;
}

/// The records, each a string, in ascending order.
std::vector<std::string> sorted(const std::string& records, size_t bytes) {
  std::vector<std::string> list;
  for (size_t i = 0; i < records.size(); i += bytes) list.push_back(records.substr(i, bytes));
  std::ranges::sort(list);
  return list;
}

class Samples : public ServerTest {
 protected:
  void SetUp() override {
    const auto path = folder.path() / "volume.isosplat";
    ASSERT_TRUE(build(small_grid(), path));
    store_ = *StoreFile::open(path);
    start();
  }

  std::string samples(const std::string& query) const {
    return "/v1/volumes/volume/" + store_->content() + "/samples?isovalue=60.5" +
           (query.empty() ? "" : "&" + query);
  }

  std::shared_ptr<StoreFile> store_;
};

constexpr size_t kRecordBytes = 28;
const std::string kAllFields = "fields=positions,normals,values&format=raw";

TEST_F(Samples, AreThePointsOfExtract) {
  for (const uint32_t level : {0u, 1u}) {
    for (const bool smooth : {true, false}) {
      const Answer answer = get(port(), samples(kAllFields + "&level=" + std::to_string(level) +
                                                (smooth ? "" : "&shading=exact")));
      EXPECT_EQ(answer.status, 200) << answer.body;
      EXPECT_TRUE(answer.complete);
      const PointArrays points = extracted(*store_, level, smooth);
      ASSERT_GT(points.positions.size(), 500u);
      EXPECT_EQ(answer.header("x-isosplat-points"), std::to_string(points.positions.size()));
      EXPECT_EQ(answer.header("x-isosplat-dtype"),
                "[('positions', '<f4', (3,)), ('normals', '<f4', (3,)), ('values', '<f4')]");
      EXPECT_TRUE(answer.body == records_of(points)) << level << smooth;
    }
  }
}

TEST_F(Samples, HaveTheVolumesValuesAtTheirPositions) {
  const VolumeGrid grid = small_grid();
  const PointArrays points = extracted(*store_, 0, false);
  ASSERT_EQ(points.values.size(), points.positions.size());
  for (size_t i = 0; i < points.values.size(); ++i) {
    const Vec3d at = multiply_transposed(grid.dual_edges(), points.positions[i] - grid.origin);
    EXPECT_NEAR(points.values[i], interpolated(at), 0.01) << i;
  }
}

TEST_F(Samples, HaveTheirSizeBeforeTheyAreRead) {
  Client client(port());
  const Answer head = client.request("HEAD", samples("fields=normals"));
  const Answer answer = get(port(), samples("fields=normals"));
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.header("content-length"), std::to_string(answer.body.size()));
  EXPECT_EQ(head.header("x-isosplat-points"), answer.header("x-isosplat-points"));
  EXPECT_EQ(answer.header("cache-control"), "public, max-age=31536000, immutable");
  const std::string etag = answer.header("etag");
  EXPECT_EQ(get(port(), samples("fields=normals"), "If-None-Match: " + etag + "\r\n").status, 304);
}

TEST_F(Samples, AreAnArrayOfNumPy) {
  const size_t count = extracted(*store_, 0, false).positions.size();
  struct Case {
    const char* fields;
    std::string type, shape;
    size_t record;
  };
  const std::string number = std::to_string(count);
  for (const Case& expected : std::initializer_list<Case>{
           {"positions", "'<f4'", "(" + number + ", 3)", 12},
           {"values", "'<f4'", "(" + number + ",)", 4},
           {"values,positions", "[('values', '<f4'), ('positions', '<f4', (3,))]",
            "(" + number + ",)", 16}}) {
    const Answer answer = get(port(), samples("fields=" + std::string(expected.fields)));
    ASSERT_GE(answer.body.size(), 10u);
    EXPECT_EQ(answer.body.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
    const size_t length =
        static_cast<uint8_t>(answer.body[8]) + (size_t{static_cast<uint8_t>(answer.body[9])} << 8);
    EXPECT_EQ((10 + length) % 64, 0u);
    ASSERT_EQ(answer.body.size(), 10 + length + count * expected.record);
    std::string text = answer.body.substr(10, length);
    EXPECT_EQ(text.back(), '\n');
    text.resize(text.find_last_not_of(" \n") + 1);
    EXPECT_EQ(text, "{'descr': " + expected.type +
                        ", 'fortran_order': False, 'shape': " + expected.shape + ", }");
  }
}

TEST_F(Samples, OfBoxesSideBySideAreThoseOfTheWhole) {
  const std::string all = get(port(), samples(kAllFields)).body;
  // Eight boxes around a point in the middle of the surface. Their outer faces are outside of the
  // volume.
  const std::array<std::array<std::string, 3>, 3> cuts = {
      {{"-900", "-21.5", "900"}, {"-900", "99.25", "900"}, {"-900", "61", "900"}}};
  std::string together;
  size_t boxes_with_points = 0;
  for (size_t octant = 0; octant < 8; ++octant) {
    std::string low, high;
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t half = octant >> axis & 1;
      low += cuts[axis][half] + ",";
      high += cuts[axis][half + 1] + (axis < 2 ? "," : "");
    }
    const Answer answer = get(port(), samples(kAllFields + "&box=" + low + high));
    ASSERT_EQ(answer.status, 200) << answer.body;
    EXPECT_EQ(answer.body.size() / kRecordBytes, std::stoul(answer.header("x-isosplat-points")));
    boxes_with_points += answer.body.empty() ? 0 : 1;
    together += answer.body;
  }
  EXPECT_GT(boxes_with_points, 3u);
  EXPECT_TRUE(sorted(together, kRecordBytes) == sorted(all, kRecordBytes));
}

TEST_F(Samples, TakeBoxesOfAnySize) {
  const std::string all = get(port(), samples("level=1")).body;
  EXPECT_TRUE(get(port(), samples("level=1&box=-1e308,-1e308,-1e308,1e308,1e308,1e308")).body ==
              all);
  const Answer beyond = get(port(), samples("level=1&box=1e300,0,-1e308,1e301,1,1e308"));
  EXPECT_EQ(beyond.status, 200);
  EXPECT_EQ(beyond.header("x-isosplat-points"), "0");
}

TEST_F(Samples, OfASurfaceThatDoesNotExistAreNone) {
  for (const std::string query : {"isovalue=-7&format=raw", "isovalue=60.5&box=0,0,0,0,0,0"}) {
    const Answer answer =
        get(port(), "/v1/volumes/volume/" + store_->content() + "/samples?" + query);
    EXPECT_EQ(answer.status, 200) << answer.body;
    EXPECT_EQ(answer.header("x-isosplat-points"), "0");
  }
}

TEST_F(Samples, RefuseMalformedQueries) {
  for (const char* query :
       {"level=x", "level=0&level=0", "box=1,2,3", "box=0,0,0,1,1,1,1", "box=0,0,1,1,1,0",
        "box=0,0,0,1,1,inf", "fields=", "fields=colours", "fields=normals,normals", "format=csv",
        "shading=flat", "isovalue=3", "other=1"}) {
    const Answer answer = get(port(), samples(query));
    EXPECT_EQ(answer.status, 400) << query;
    EXPECT_EQ(Json::parse(answer.body)["status"], "invalid_argument");
  }
  EXPECT_EQ(get(port(), samples("level=99")).status, 404);
}

TEST_F(Samples, AreComputedOnSeparateThreads) {
  ASSERT_EQ(get(port(), samples("")).status, 200);
  const std::string metrics = get(port(), "/metrics").body;
  const std::string name = "\nisosplat_computations_total ";
  const size_t at = metrics.find(name);
  ASSERT_NE(at, std::string::npos) << metrics;
  // At least two turns: one to count the points, and one for a piece of the body.
  EXPECT_GE(std::stoul(metrics.substr(at + name.size())), 2u);
}

TEST_F(Samples, OfADamagedChunkAreAnError) {
  const float isovalue = store_->info().mapping.quantized_isovalue(kIsovalue);
  const auto chunks = store_->chunks_for(0, isovalue, isovalue);
  ASSERT_TRUE(chunks);
  std::vector<std::byte> file(store_->info().file_bytes);
  ASSERT_TRUE(store_->read(0, file));
  file[chunks->chunks.back().offset] ^= std::byte{1};
  write_file(folder.path() / "damaged.isosplat", file);
  const std::string target = "/v1/volumes/damaged/" + store_->content() + "/samples?isovalue=60.5";
  ASSERT_TRUE(eventually([&] { return get(port(), target).status != 404; }));
  const Answer answer = get(port(), target);
  EXPECT_EQ(answer.status, 500);
  EXPECT_EQ(Json::parse(answer.body)["status"], "checksum_mismatch");
}

TEST_F(Samples, BeyondALimitAreRefused) {
  const auto ignore = [](std::string_view) {};
  Catalog catalog({folder.path()}, ignore);
  StorePool stores({.stores = 1, .directory_bytes = 1 << 20}, ignore);
  ScenePool scenes({}, ScenePool::OutsideLinks::followed, ignore);
  catalog.scan();
  const std::string target = samples("");
  Request request;
  request.method = Method::get;
  request.target = target;
  const auto status_with = [&](const RouterLimits& limits) {
    return Router(catalog, stores, scenes, limits).respond(request).status;
  };
  EXPECT_EQ(status_with({}), 200);
  EXPECT_EQ(status_with({.query_bytes = 100}), 413);
  EXPECT_EQ(status_with({.query_cells = 100}), 413);
  EXPECT_EQ(status_with({.query_border_bytes = 100}), 413);
}

TEST_F(Samples, HaveDoublesWhereSinglesWouldMoveThem) {
  VolumeGrid grid = small_grid();
  grid.origin = {500'000, 5'400'000, 0};
  ASSERT_TRUE(needs_doubles(grid));
  const auto path = folder.path() / "far.isosplat";
  ASSERT_TRUE(build(grid, path));
  const auto far = *StoreFile::open(path);
  const std::string target = "/v1/volumes/far/" + far->content() +
                             "/samples?isovalue=60.5&level=2&fields=positions&format=raw";
  ASSERT_TRUE(eventually([&] { return get(port(), target).status == 200; }));
  const Answer answer = get(port(), target);
  EXPECT_EQ(answer.header("x-isosplat-dtype"), "[('positions', '<f8', (3,))]");
  std::string expected;
  for (const Vec3d& p : extracted(*far, 2, false).positions) append(expected, {p.x, p.y, p.z});
  EXPECT_TRUE(answer.body == expected);
}

class Isovalues : public ServerTest {
 protected:
  void SetUp() override { start(); }

  /// alpha's mapping: value = −100 + quantized / 2.
  void expect_needs(const Json& needs, uint32_t level) const {
    const float quantized = static_cast<float>((needs["isovalue"].get<double>() + 100) * 2);
    uint64_t bytes = 0, cells = 0;
    const auto chunks = alpha.meeting(level, quantized, quantized);
    for (const KnownChunk* chunk : chunks) {
      bytes += chunk->bytes.size();
      cells += chunk->cells;
    }
    EXPECT_EQ(needs["chunks"], chunks.size()) << needs;
    EXPECT_EQ(needs["bytes"], bytes) << needs;
    EXPECT_EQ(needs["cells"], cells) << needs;
  }
};

TEST_F(Isovalues, HaveTheChunksBytesAndCellsOfTheDirectory) {
  for (const uint32_t level : {0u, 1u}) {
    for (const std::string query : {"isovalue=-100..27.5&steps=256", "isovalue=0,-42.25,-90,0",
                                    "isovalue=-60", "isovalue=-1e9..1e9"}) {
      const Answer answer =
          get(port(), content("isovalues?" + query + "&level=" + std::to_string(level)));
      ASSERT_EQ(answer.status, 200) << answer.body;
      EXPECT_EQ(answer.header("content-type"), "application/json");
      EXPECT_EQ(answer.header("cache-control"), "public, max-age=31536000, immutable");
      const Json body = Json::parse(answer.body);
      EXPECT_EQ(body["level"], level);
      for (const Json& needs : body["isovalues"]) expect_needs(needs, level);
    }
  }
  const Json range = Json::parse(get(port(), content("isovalues?isovalue=-100..0&steps=3")).body);
  ASSERT_EQ(range["isovalues"].size(), 3u);
  EXPECT_EQ(range["isovalues"][1]["isovalue"], -50.0);
  const Json list = Json::parse(get(port(), content("isovalues?isovalue=3,1,3")).body);
  ASSERT_EQ(list["isovalues"].size(), 3u);
  EXPECT_EQ(list["isovalues"][1]["isovalue"], 1.0);
  EXPECT_FALSE(list["isovalues"][0].contains("activeCells"));
}

TEST_F(Isovalues, HaveTheActiveCellsOfTheMetadata) {
  const KnownStore store = make_store(
      3, {90, 80, 70}, 300, R"({"active_cells":{"low":-100,"high":0,"counts":[5,6,7,8]}})");
  write_file(folder.path() / "beta.isosplat", store.file);
  const std::string target = "/v1/volumes/beta/" + store.content + "/isovalues?isovalue=";
  ASSERT_TRUE(eventually([&] { return get(port(), target + "0").status == 200; }));
  const Json needs = Json::parse(get(port(), target + "-100,-76,-74,0,1").body)["isovalues"];
  EXPECT_EQ(needs[0]["activeCells"], 5);
  EXPECT_EQ(needs[1]["activeCells"], 5);
  EXPECT_EQ(needs[2]["activeCells"], 6);
  EXPECT_EQ(needs[3]["activeCells"], 8);
  EXPECT_FALSE(needs[4].contains("activeCells"));
  const Json coarse = Json::parse(get(port(), target + "-100&level=1").body)["isovalues"];
  EXPECT_FALSE(coarse[0].contains("activeCells"));
}

TEST_F(Isovalues, RefuseMalformedQueries) {
  for (const char* query : {"isovalues", "isovalues?isovalue=", "isovalues?isovalue=1,,2",
                            "isovalues?isovalue=2..1", "isovalues?isovalue=1..2&steps=1",
                            "isovalues?isovalue=1..2&steps=1025", "isovalues?isovalue=1&steps=2",
                            "isovalues?isovalue=1&level=-1", "isovalues?isovalue=1&other=1"}) {
    EXPECT_EQ(get(port(), content(query)).status, 400) << query;
  }
  EXPECT_EQ(get(port(), content("isovalues?isovalue=1&level=99")).status, 404);
}

}  // namespace
}  // namespace isosplat::server::test
