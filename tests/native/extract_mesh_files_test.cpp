// GLB and 3MF files, and the choice of a format, with a tetrahedron in two parts.
#include "tests/native/mesh_files.h"

namespace isosplat {
namespace {

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

TEST_F(MeshFiles, GlbHasANodeForEachObjectWithTriangles) {
  const auto [scene, data] = parse_glb(write_objects("a.glb"));
  ASSERT_EQ(scene["nodes"].size(), 3u);
  EXPECT_EQ(scene["nodes"][0]["children"], nlohmann::json({1, 2}));
  EXPECT_EQ(scene["nodes"][1]["name"], "first <one>");
  EXPECT_EQ(scene["nodes"][2]["name"], "Sch\u00e4del \"2\"");
  EXPECT_EQ(scene["nodes"][2]["mesh"], 1);
  const auto& surface = scene["meshes"][1]["primitives"][0];
  EXPECT_EQ(scene["meshes"].size(), 2u);
  const auto& positions = scene["accessors"][surface["attributes"]["POSITION"].get<size_t>()];
  EXPECT_EQ(positions["min"], nlohmann::json({7, 0, 0}));
  EXPECT_EQ(positions["count"], 4);
  const size_t at = positions["byteOffset"];
  EXPECT_EQ(value_at<Vec3f>(data, at + 24), (Vec3f{8, 0, 0}));
  const auto& triangles = scene["accessors"][surface["indices"].get<size_t>()];
  const size_t first =
      scene["bufferViews"][1]["byteOffset"].get<size_t>() + triangles["byteOffset"].get<size_t>();
  EXPECT_EQ(triangles["count"], 12);
  EXPECT_EQ(value_at<uint32_t>(data, first + 4), 2u);  // numbered within the object
  const auto& material = scene["materials"][surface["material"].get<size_t>()];
  EXPECT_EQ(material["alphaMode"], "BLEND");
  EXPECT_EQ(material["pbrMetallicRoughness"]["baseColorFactor"], nlohmann::json({0, 0, 1, 0.5}));
  EXPECT_FALSE(scene["materials"][0].contains("alphaMode"));
}

/// A GLB file reserves space for its JSON text before the first vertex. The longest names fit into
/// it.
TEST_F(MeshFiles, GlbHasSpaceForManyLongNames) {
  std::vector<MeshObject> objects;
  for (int i = 0; i < 300; ++i) {
    objects.push_back({std::string(400, i % 2 ? '\x01' : '"'),
                       {0.1f, 0.2f, 0.3f},
                       0.7f,
                       {{10, 10, 10}, {0.01, 0.01, 0.01}, {400000.123, 5000000.123, 1e6}}});
  }
  const auto format = mesh_format("a.glb", SurfaceContent::triangles);
  auto file = (*format)->create(path("a.glb"),
                                {objects[0].grid, 1, "", SurfaceContent::triangles, objects});
  ASSERT_TRUE(file);
  for (size_t i = 0; i < objects.size(); ++i) {
    if (i > 0) {
      ASSERT_TRUE((*file)->next_object());
    }
    for (const MeshPart& part : tetrahedron({400000.1234, 5000000.1234, 1e6})) {
      ASSERT_TRUE((*file)->append(part));
    }
  }
  ASSERT_TRUE((*file)->publish());
  const auto [scene, data] = parse_glb(content_of(path("a.glb")));
  EXPECT_EQ(scene["meshes"].size(), 300u);
}

TEST_F(MeshFiles, ObjHasAGroupForEachObject) {
  const std::string text = write_objects("a.obj");
  EXPECT_NE(text.find("o first_<one>\ng first_<one>\nv 0 0 0\n"), std::string::npos) << text;
  EXPECT_NE(text.find("o empty\ng empty\no Sch\u00e4del_\"2\"\n"), std::string::npos) << text;
  EXPECT_NE(text.find("v 8 0 0\n"), std::string::npos);
  EXPECT_NE(text.find("f 5//5 7//7 6//6\n"), std::string::npos);  // numbered within the file
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

TEST_F(MeshFiles, ThreeMfHasANamedObjectInItsColour) {
  auto files = unzip(write_objects("a.3mf"));
  const std::string& model = files["3D/3dmodel.model"];
  const auto expect = [&](const std::string& text) {
    EXPECT_NE(model.find(text), std::string::npos) << text << " in " << model;
  };
  expect("<base name=\"first &lt;one&gt;\" displaycolor=\"#FF0000FF\"/>");
  expect("<base name=\"Sch\u00e4del &quot;2&quot;\" displaycolor=\"#0000FF80\"/>");
  expect("<object id=\"2\" type=\"model\" name=\"first &lt;one&gt;\" pid=\"1\" pindex=\"0\">");
  expect(
      "<object id=\"4\" type=\"model\" name=\"Sch\u00e4del &quot;2&quot;\" pid=\"1\" pindex=\"2\">"
      "<mesh><vertices>\n<vertex x=\"7\"");
  expect("<build><item objectid=\"2\"/><item objectid=\"4\"/></build>");
  EXPECT_EQ(model.find("id=\"3\""), std::string::npos);
}

TEST_F(MeshFiles, ThreeMfWithoutTrianglesHasNoObject) {
  auto files = unzip(write("a.3mf", std::array<MeshPart, 0>{}));
  EXPECT_EQ(files["3D/3dmodel.model"].find("<object"), std::string::npos);
}

/// The dictionary of an array file's header; removes the header from `bytes`.
std::string take_npy_header(std::string& bytes) {
  EXPECT_TRUE(bytes.starts_with(std::string_view("\x93NUMPY\x01\x00", 8)));
  const size_t end = 10 + value_at<uint16_t>(bytes, 8);
  EXPECT_EQ(end % 64, 0u);
  EXPECT_EQ(bytes.at(end - 1), '\n');
  const std::string header = bytes.substr(10, bytes.find_last_not_of(" \n", end - 1) - 9);
  bytes.erase(0, end);
  return header;
}

TEST_F(MeshFiles, NpyIsOneArrayOfPoints) {
  const auto parts = tetrahedron({0.125, 0, 0});
  std::string bytes = write("a.npy", parts, {{2, 2, 2}}, SurfaceContent::points);
  EXPECT_EQ(take_npy_header(bytes),
            "{'descr': [('position', '<f4', (3,)), ('normal', '<f4', (3,)), ('value', '<f8')], "
            "'fortran_order': False, 'shape': (4,), }");
  ASSERT_EQ(bytes.size(), 4u * 32);
  EXPECT_EQ(value_at<Vec3f>(bytes, 32), (Vec3f{1.125f, 0, 0}));
  EXPECT_EQ(value_at<Vec3f>(bytes, 32 + 12), (Vec3f{1, 0, 0}));
  EXPECT_EQ(value_at<double>(bytes, 32 + 24), 1.5);
  EXPECT_EQ(value_at<Vec3f>(bytes, 96), (Vec3f{0.125f, 0, 3}));
}

TEST_F(MeshFiles, NpzHasAnArrayForEachProperty) {
  const auto parts = tetrahedron({0.125, 0, 0});
  auto files = unzip(write("a.npz", parts));
  ASSERT_EQ(files.size(), 4u);
  const auto header = [&](const char* name) { return take_npy_header(files[name]); };
  EXPECT_EQ(header("positions.npy"), "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3), }");
  EXPECT_EQ(header("normals.npy"), "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3), }");
  EXPECT_EQ(header("triangles.npy"), "{'descr': '<u4', 'fortran_order': False, 'shape': (4, 3), }");
  EXPECT_EQ(header("isovalue.npy"), "{'descr': '<f8', 'fortran_order': False, 'shape': (), }");
  EXPECT_EQ(value_at<Vec3f>(files["positions.npy"], 36), (Vec3f{0.125f, 0, 3}));
  EXPECT_EQ(files["positions.npy"].size(), 48u);
  EXPECT_EQ(value_at<Vec3f>(files["normals.npy"], 36), (Vec3f{0, 0, 1}));
  EXPECT_EQ(value_at<uint32_t>(files["triangles.npy"], 44), 3u);
  EXPECT_EQ(value_at<double>(files["isovalue.npy"], 0), 1.5);
  EXPECT_EQ(
      unzip(write("b.npz", parts, {{2, 2, 2}}, SurfaceContent::points)).count("triangles.npy"), 0u);
}

TEST_F(MeshFiles, ArraysHaveDoublesWhereSinglePrecisionIsTooCoarse) {
  const VolumeGrid far{{2, 2, 2}, {0.25, 0.25, 0.25}, {500000, 5200000, 120}};
  const auto parts = tetrahedron({500000.0625, 5200000, 120});
  std::string points = write("a.npy", parts, far, SurfaceContent::points);
  EXPECT_NE(take_npy_header(points).find("'position', '<f8'"), std::string::npos);
  EXPECT_EQ(value_at<double>(points, 44), 500001.0625);
  auto files = unzip(write("a.npz", parts, far));
  EXPECT_NE(take_npy_header(files["positions.npy"]).find("'<f8'"), std::string::npos);
  EXPECT_EQ(value_at<double>(files["positions.npy"], 24), 500001.0625);
}

TEST_F(MeshFiles, AreChosenByTheirExtension) {
  constexpr auto kTriangles = SurfaceContent::triangles;
  EXPECT_EQ((*mesh_format("a.STL", kTriangles))->extension, ".stl");
  EXPECT_EQ((*mesh_format("folder.ply/a.3mf", kTriangles))->extension, ".3mf");
  EXPECT_EQ((*mesh_format("a.NPY", SurfaceContent::points))->extension, ".npy");
  const auto message = [](const char* path, SurfaceContent content) {
    const auto refused = mesh_format(path, content);
    return refused ? "accepted" : refused.error().message;
  };
  EXPECT_EQ(message("a.vtk", kTriangles),
            "a.vtk: expected an extension for triangles (.ply, .stl, .obj, .glb, .3mf, "
            ".npz, .vtp), found \".vtk\": choose one of them");
  EXPECT_EQ(message("a.npy", kTriangles),
            "a.npy: expected an extension for triangles (.ply, .stl, .obj, .glb, .3mf, "
            ".npz, .vtp), found \".npy\": choose one of them, or write points without --mesh");
  EXPECT_EQ(message("a.stl", SurfaceContent::points),
            "a.stl: expected an extension for points (.ply, .npy, .npz, .vtp), found "
            "\".stl\": choose one of them, or write triangles with --mesh");
  EXPECT_EQ(message("a", SurfaceContent::points),
            "a: expected an extension for points (.ply, .npy, .npz, .vtp), found \"\": choose "
            "one of them");
}

TEST_F(MeshFiles, NeedAFolderThatExists) {
  for (const char* name :
       {"none/a.ply", "none/a.stl", "none/a.obj", "none/a.glb", "none/a.3mf", "none/a.npz"}) {
    const VolumeGrid grid{{2, 2, 2}};
    const auto file =
        (*mesh_format(name, SurfaceContent::triangles))->create(path(name), {grid, 1, ""});
    ASSERT_FALSE(file) << name;
    EXPECT_EQ(file.error().status, Status::io_error);
  }
}

}  // namespace
}  // namespace isosplat
