// GLB and 3MF files, and the choice of a format, with a tetrahedron in two parts.
#include <archive.h>
#include <archive_entry.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "native/extract/mesh_file.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The second part refers to vertices of the first one. One vertex has no normal.
std::array<MeshPart, 2> tetrahedron(Vec3d at = {}) {
  MeshPart first, second;
  first.vertices.positions = {at, at + Vec3d{1, 0, 0}, at + Vec3d{0, 2, 0}};
  first.vertices.normals = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  first.triangles = {{0, 2, 1}};
  second.vertices.positions = {at + Vec3d{0, 0, 3}};
  second.vertices.normals = {{0, 0, 1}};
  second.triangles = {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return {first, second};
}

class MeshFiles : public testing::Test {
 protected:
  std::filesystem::path path(const char* name) { return folder_.path() / name; }

  /// The content of a file of these parts.
  template <class Parts>
  std::string write(const char* name, const Parts& parts, const VolumeGrid& grid = {{2, 2, 2}}) {
    const auto format = mesh_format(path(name));
    EXPECT_TRUE(format);
    auto file = (*format)->create(path(name), grid, "isosurface 1 of <a> & b\xFC");
    EXPECT_TRUE(file);
    for (const MeshPart& part : parts) {
      const auto appended = (*file)->append(part);
      EXPECT_TRUE(appended) << appended.error().message;
    }
    EXPECT_FALSE(std::filesystem::exists(path(name)));
    const auto published = (*file)->publish();
    EXPECT_TRUE(published) << published.error().message;
    std::string content = content_of(path(name));
    EXPECT_EQ(content.size(), (*file)->bytes());
    EXPECT_TRUE(content.starts_with((*format)->beginning));
    return content;
  }

  TemporaryFolder folder_;
};

template <class T>
T value_at(const std::string& content, size_t offset) {
  T value;
  EXPECT_LE(offset + sizeof value, content.size());
  std::memcpy(&value, &content.at(offset), sizeof value);
  return value;
}

struct Glb {
  nlohmann::json scene;
  std::string data;
};

/// Reads a GLB file as the specification says, with all lengths checked.
Glb parse_glb(const std::string& content) {
  EXPECT_EQ(value_at<uint32_t>(content, 4), 2u);
  EXPECT_EQ(value_at<uint32_t>(content, 8), content.size());
  const auto json_bytes = value_at<uint32_t>(content, 12);
  EXPECT_EQ(content.substr(16, 4), "JSON");
  EXPECT_EQ(json_bytes % 4, 0u);
  Glb glb{nlohmann::json::parse(content.substr(20, json_bytes)), {}};
  const size_t data = 20 + json_bytes;
  if (data == content.size()) return glb;
  EXPECT_EQ(content.substr(data + 4, 4), std::string("BIN\0", 4));
  glb.data = content.substr(data + 8);
  EXPECT_EQ(glb.data.size(), value_at<uint32_t>(content, data));
  EXPECT_EQ(glb.data.size(), glb.scene["buffers"][0]["byteLength"]);
  return glb;
}

TEST_F(MeshFiles, GlbHasVerticesThenTriangles) {
  const auto parts = tetrahedron();
  const auto [scene, data] = parse_glb(write("a.glb", parts));
  EXPECT_EQ(scene["accessors"][0]["count"], 4);
  EXPECT_EQ(scene["accessors"][0]["min"], nlohmann::json({0, 0, 0}));
  EXPECT_EQ(scene["accessors"][0]["max"], nlohmann::json({1, 2, 3}));
  EXPECT_EQ(scene["accessors"][2]["count"], 12);
  EXPECT_EQ(value_at<float>(data, 2 * 24 + 4), 2.0f);       // position 2, y
  EXPECT_EQ(value_at<float>(data, 3 * 24 + 12 + 8), 1.0f);  // normal 3, z
  EXPECT_EQ(value_at<float>(data, 12 + 8), 1.0f);           // no normal: a unit vector
  EXPECT_EQ(scene["bufferViews"][1]["byteOffset"], 4 * 24);
  EXPECT_EQ(value_at<uint32_t>(data, 4 * 24 + 4), 2u);       // triangle 0, second vertex
  EXPECT_EQ(value_at<uint32_t>(data, 4 * 24 + 12 + 8), 3u);  // triangle 1, third vertex
  EXPECT_EQ(scene["nodes"][0]["scale"][0], 0.001);
}

TEST_F(MeshFiles, GlbKeepsPrecisionFarFromTheOrigin) {
  const Vec3d far{400000.25, 5000000.5, 0};
  const VolumeGrid grid{.voxels = {10, 10, 10}, .spacing = {0.01, 0.01, 0.01}, .origin = far};
  const auto [scene, data] = parse_glb(write("a.glb", tetrahedron(far), grid));
  const auto& offset = scene["nodes"][1]["translation"];
  EXPECT_NEAR(offset[0].get<double>() + double{value_at<float>(data, 24)}, far.x + 1, 1e-6);
  EXPECT_NEAR(offset[1].get<double>() + double{value_at<float>(data, 2 * 24 + 4)}, far.y + 2, 1e-6);
}

TEST_F(MeshFiles, GlbWithoutTrianglesHasAScene) {
  const auto [scene, data] = parse_glb(write("a.glb", std::array<MeshPart, 0>{}));
  EXPECT_EQ(scene["asset"]["version"], "2.0");
  EXPECT_FALSE(scene.contains("meshes"));
  EXPECT_TRUE(data.empty());
}

/// The files of a ZIP archive, by name.
std::map<std::string, std::string> unzip(const std::string& content) {
  std::map<std::string, std::string> files;
  archive* const reader = archive_read_new();
  archive_read_support_format_zip(reader);
  EXPECT_EQ(archive_read_open_memory(reader, content.data(), content.size()), ARCHIVE_OK);
  archive_entry* entry = nullptr;
  while (archive_read_next_header(reader, &entry) == ARCHIVE_OK) {
    std::string& file = files[archive_entry_pathname(entry)];
    char buffer[4096];
    la_ssize_t count = 0;
    while ((count = archive_read_data(reader, buffer, sizeof buffer)) > 0) {
      file.append(buffer, static_cast<size_t>(count));
    }
    EXPECT_EQ(count, 0) << archive_error_string(reader);
  }
  archive_read_free(reader);
  return files;
}

TEST_F(MeshFiles, ThreeMfIsAnArchiveWithAModel) {
  const auto parts = tetrahedron({0.125, 0, 0});
  auto files = unzip(write("a.3mf", parts));
  EXPECT_EQ(files.size(), 3u);
  EXPECT_NE(files["[Content_Types].xml"].find("Extension=\"model\""), std::string::npos);
  EXPECT_NE(files["_rels/.rels"].find("Target=\"/3D/3dmodel.model\""), std::string::npos);
  const std::string& model = files["3D/3dmodel.model"];
  EXPECT_NE(model.find("unit=\"millimeter\""), std::string::npos);
  EXPECT_NE(model.find("of &lt;a&gt; &amp; b?<"), std::string::npos);
  EXPECT_NE(model.find("<vertex x=\"1.125\" y=\"0\" z=\"0\"/>"), std::string::npos);
  EXPECT_NE(model.find("<triangle v1=\"2\" v2=\"0\" v3=\"3\"/>\n</triangles>"), std::string::npos);
  EXPECT_TRUE(model.ends_with("</model>\n"));
}

TEST_F(MeshFiles, ThreeMfWithoutTrianglesHasNoObject) {
  auto files = unzip(write("a.3mf", std::array<MeshPart, 0>{}));
  EXPECT_EQ(files["3D/3dmodel.model"].find("<object"), std::string::npos);
}

TEST_F(MeshFiles, AreChosenByTheirExtension) {
  EXPECT_EQ((*mesh_format("a.STL"))->extension, ".stl");
  EXPECT_EQ((*mesh_format("folder.ply/a.3mf"))->extension, ".3mf");
  const auto unknown = mesh_format("a.vtk");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().message,
            "a.vtk: expected the extension of a mesh file (.ply, .stl, .obj, .glb, .3mf), found "
            "\".vtk\": choose one of them");
}

TEST_F(MeshFiles, NeedAFolderThatExists) {
  for (const char* name : {"none/a.ply", "none/a.stl", "none/a.obj", "none/a.glb", "none/a.3mf"}) {
    const auto file = (*mesh_format(name))->create(path(name), {{2, 2, 2}}, "");
    ASSERT_FALSE(file) << name;
    EXPECT_EQ(file.error().status, Status::io_error);
  }
}

}  // namespace
}  // namespace isosplat
