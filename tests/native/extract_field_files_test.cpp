// Values of fields in files, with a tetrahedron in two parts.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/native/mesh_files.h"

namespace isosplat {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// The tetrahedron with two fields.
std::array<MeshPart, 2> tetrahedron_with_fields() {
  auto parts = tetrahedron();
  parts[0].vertices.fields = {{1, 2, kNone}, {-5, -6, -7}};
  parts[1].vertices.fields = {{4}, {-8}};
  return parts;
}

const std::vector<FieldColumn> kFields{{"nx", "Static \"pressure\"", "Pa"}, {"a.b-C9", "", ""}};

TEST_F(MeshFiles, PlyHasAPropertyForEachField) {
  for (const auto content : {SurfaceContent::triangles, SurfaceContent::points}) {
    const std::string text = write(content == SurfaceContent::points ? "points.ply" : "mesh.ply",
                                   tetrahedron_with_fields(), {{2, 2, 2}}, content, kFields);
    const size_t end = text.find("end_header\n") + 11;
    EXPECT_NE(text.find("comment nx: Static \"pressure\", in Pa\ncomment a.b-C9\n"),
              std::string::npos);
    EXPECT_NE(text.find("property float nz\nproperty float nx_field\nproperty float a.b-C9\n"),
              std::string::npos);
    EXPECT_TRUE(std::isnan(value_at<float>(text, end + 2 * 32 + 24)));
    EXPECT_EQ(value_at<float>(text, end + 3 * 32 + 24), 4);
    EXPECT_EQ(value_at<float>(text, end + 3 * 32 + 28), -8);
    EXPECT_EQ(text.size(), end + 4 * 32 + (content == SurfaceContent::points ? 0 : 4 * 13));
  }
}

TEST_F(MeshFiles, GlbHasAttributesAndColoursOfFields) {
  const auto parts = tetrahedron_with_fields();
  const auto [scene, data] =
      parse_glb(write("a.glb", parts, {{2, 2, 2}}, SurfaceContent::triangles, kFields));
  const auto& mesh = scene["meshes"][0];
  const auto& attributes = mesh["primitives"][0]["attributes"];
  const auto start = [&](const char* name) {
    const auto& accessor = scene["accessors"][attributes[name].get<size_t>()];
    EXPECT_EQ(accessor["count"], 4);
    const auto& view = scene["bufferViews"][accessor["bufferView"].get<size_t>()];
    return view["byteOffset"].get<size_t>() + accessor["byteOffset"].get<size_t>();
  };
  const size_t nx = start("_NX"), other = start("_A_B_C9"), colours = start("COLOR_0");
  EXPECT_EQ(nx, 4u * 24 + 4 * 12);
  EXPECT_EQ(value_at<float>(data, nx + 4), 2);
  EXPECT_EQ(value_at<float>(data, nx + 8), std::numeric_limits<float>::lowest());
  EXPECT_EQ(value_at<float>(data, other + 12), -8);
  // Linear light of viridis: (68, 1, 84) for the lowest value, (253, 231, 37) for the highest.
  const auto channel = [&](size_t vertex, size_t i) {
    return value_at<uint16_t>(data, colours + 8 * vertex + 2 * i) / 65535.0;
  };
  EXPECT_NEAR(channel(0, 0), std::pow((68 / 255.0 + 0.055) / 1.055, 2.4), 1e-4);
  EXPECT_NEAR(channel(3, 1), std::pow((231 / 255.0 + 0.055) / 1.055, 2.4), 1e-4);
  EXPECT_NEAR(channel(2, 2), std::pow((128 / 255.0 + 0.055) / 1.055, 2.4), 1e-4);  // missing
  EXPECT_EQ(channel(1, 3), 1);
  EXPECT_EQ(data.size(), colours + 4 * 8);
  const auto& fields = mesh["extras"]["fields"];
  EXPECT_EQ(fields[0]["units"], "Pa");
  EXPECT_EQ(fields[0]["coloured"], nlohmann::json({1, 4}));
  EXPECT_EQ(fields[1]["attribute"], "_A_B_C9");
  EXPECT_EQ(fields[1]["name"], "a.b-C9");
  EXPECT_EQ(scene["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"],
            nlohmann::json({1, 1, 1, 1}));
}

/// Values beyond single precision are infinite in FieldValues. glTF has no infinities, and its
/// lowest number stands for missing values.
TEST_F(MeshFiles, GlbHasFiniteValuesAndColours) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kLargest = std::numeric_limits<float>::max();
  auto parts = tetrahedron_with_fields();
  parts[0].vertices.fields[0] = {-kInfinity, kInfinity, kNone};
  parts[1].vertices.fields[0] = {0};
  const auto [scene, data] =
      parse_glb(write("a.glb", parts, {{2, 2, 2}}, SurfaceContent::triangles, kFields));
  const auto& mesh = scene["meshes"][0];
  const auto start = [&](const char* name) {
    const auto& attributes = mesh["primitives"][0]["attributes"];
    const auto& accessor = scene["accessors"][attributes[name].get<size_t>()];
    const auto& view = scene["bufferViews"][accessor["bufferView"].get<size_t>()];
    return view["byteOffset"].get<size_t>() + accessor["byteOffset"].get<size_t>();
  };
  const size_t nx = start("_NX"), colours = start("COLOR_0");
  EXPECT_EQ(value_at<float>(data, nx), -std::nextafter(kLargest, 0.0f));
  EXPECT_EQ(value_at<float>(data, nx + 4), kLargest);
  EXPECT_EQ(value_at<float>(data, nx + 8), -kLargest);  // missing
  EXPECT_EQ(mesh["extras"]["fields"][0]["coloured"],
            nlohmann::json({-std::nextafter(kLargest, 0.0f), kLargest}));
  // Blue in linear light: of the first and the last colour of viridis, and of the middle one.
  const auto blue = [&](size_t vertex) {
    return value_at<uint16_t>(data, colours + 8 * vertex + 4) / 65535.0;
  };
  const auto linear = [](double srgb) { return std::pow((srgb / 255 + 0.055) / 1.055, 2.4); };
  EXPECT_NEAR(blue(0), linear(84), 1e-4);
  EXPECT_NEAR(blue(1), linear(37), 1e-4);
  EXPECT_NEAR(blue(3), linear(140), 0.01);
}

/// Objects of a scene whose store lacks a field have only missing values.
TEST_F(MeshFiles, GlbHasNoAttributeWithoutValues) {
  const std::array<MeshObject, 2> objects{
      {{"without", {1, 0, 0}, 1, {{2, 2, 2}}}, {"with", {0, 0, 1}, 0.5f, {{2, 2, 2}}}}};
  const auto format = mesh_format("a.glb", SurfaceContent::triangles);
  auto file = (*format)->create(
      path("a.glb"), {objects[0].grid, 1, "", SurfaceContent::triangles, objects, kFields});
  ASSERT_TRUE(file);
  for (MeshPart part : tetrahedron_with_fields()) {
    for (auto& values : part.vertices.fields) std::ranges::fill(values, kNone);
    ASSERT_TRUE((*file)->append(part));
  }
  ASSERT_TRUE((*file)->next_object());
  for (const MeshPart& part : tetrahedron_with_fields()) ASSERT_TRUE((*file)->append(part));
  ASSERT_TRUE((*file)->publish());
  const auto [scene, data] = parse_glb(content_of(path("a.glb")));
  EXPECT_EQ(scene["meshes"][0]["primitives"][0]["attributes"].size(), 2u);
  EXPECT_FALSE(scene["meshes"][0].contains("extras"));
  EXPECT_EQ(scene["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"],
            nlohmann::json({1, 0, 0, 1}));
  const auto& attributes = scene["meshes"][1]["primitives"][0]["attributes"];
  EXPECT_EQ(attributes.size(), 5u);
  const auto& values = scene["accessors"][attributes["_NX"].get<size_t>()];
  const size_t at =
      scene["bufferViews"][2]["byteOffset"].get<size_t>() + values["byteOffset"].get<size_t>();
  EXPECT_EQ(value_at<float>(data, at), 1);
}

TEST_F(MeshFiles, NumPyHasAnArrayForEachField) {
  const auto parts = tetrahedron_with_fields();
  auto files = unzip(write("a.npz", parts, {{2, 2, 2}}, SurfaceContent::triangles, kFields));
  ASSERT_TRUE(files.contains("nx.npy"));
  EXPECT_EQ(value_at<float>(files["a.b-C9.npy"], 256 + 12), -8);
  EXPECT_TRUE(std::isnan(value_at<float>(files["nx.npy"], 256 + 8)));
  EXPECT_NE(files["nx.npy"].find("'descr': '<f4'"), std::string::npos);
  EXPECT_NE(files["nx.npy"].find("'shape': (4,)"), std::string::npos);
  std::vector<FieldColumn> many(16);
  for (size_t i = 0; i < many.size(); ++i) many[i].name = std::string(63, 'a') + char('a' + i);
  std::array<MeshPart, 1> part;
  part[0].vertices.positions = {{1, 2, 3}};
  part[0].vertices.normals = {{0, 0, 1}};
  for (size_t i = 0; i < many.size(); ++i) part[0].vertices.fields.push_back({float(i)});
  const std::string text = write("a.npy", part, {{2, 2, 2}}, SurfaceContent::points, many);
  const size_t header = 10 + value_at<uint16_t>(text, 8);
  EXPECT_EQ(header % 64, 0u);
  EXPECT_EQ(text[header - 1], '\n');
  EXPECT_NE(text.substr(0, header).find("('" + many[15].name + "', '<f4')]"), std::string::npos);
  EXPECT_EQ(text.size(), header + 32 + 16 * 4);
  EXPECT_EQ(value_at<float>(text, header + 32 + 15 * 4), 15);
}

TEST_F(MeshFiles, OtherFormatsRefuseFields) {
  for (const char* name : {"a.stl", "a.obj", "a.3mf"}) {
    const auto format = mesh_format(name, SurfaceContent::triangles);
    const auto checked = check_holds_fields(name, **format, SurfaceContent::triangles);
    ASSERT_FALSE(checked);
    EXPECT_NE(checked.error().message.find("(.ply, .glb, .npz, .vtp)"), std::string::npos)
        << checked.error().message;
  }
}

}  // namespace
}  // namespace isosplat
