// Files of VTK's XML format for surfaces, with a tetrahedron in two parts.
#include <cmath>
#include <limits>

#include "tests/native/mesh_files.h"

namespace isosplat {
namespace {

using VtpFiles = MeshFiles;

/// The attribute of the element that begins at `at`.
std::string attribute(const std::string& xml, size_t at, const std::string& name) {
  const size_t begin = xml.find(" " + name + "=\"", at) + name.size() + 3;
  EXPECT_LT(begin, xml.find('>', at)) << name;
  return xml.substr(begin, xml.find('"', begin) - begin);
}

/// The values of the array with this name. Checks its type and its length.
template <class T>
std::vector<T> array_of(const std::string& xml, const std::string& name, const std::string& type,
                        size_t count) {
  const size_t tag = xml.rfind('<', xml.find("Name=\"" + name + "\""));
  EXPECT_EQ(attribute(xml, tag, "type"), type);
  const std::string begin = "<AppendedData encoding=\"raw\">\n_";
  const size_t at = xml.find(begin) + begin.size() + std::stoul(attribute(xml, tag, "offset"));
  EXPECT_EQ(value_at<uint64_t>(xml, at), count * sizeof(T)) << name;
  std::vector<T> values;
  for (size_t i = 0; i < count; ++i) values.push_back(value_at<T>(xml, at + 8 + i * sizeof(T)));
  return values;
}

TEST_F(VtpFiles, HaveTrianglesAndFields) {
  auto parts = tetrahedron();
  parts[0].vertices.fields = {{1, 2, std::numeric_limits<float>::quiet_NaN()}};
  parts[1].vertices.fields = {{4}};
  const std::vector<FieldColumn> fields{{"Normals", "", "<m/s> & \"s\""}};
  const std::string xml = write("a.vtp", parts, {{2, 2, 2}}, SurfaceContent::triangles, fields);
  const size_t piece = xml.find("<Piece");
  EXPECT_EQ(attribute(xml, piece, "NumberOfPoints"), "4");
  EXPECT_EQ(attribute(xml, piece, "NumberOfPolys"), "4");
  EXPECT_EQ(attribute(xml, piece, "NumberOfVerts"), "0");
  const auto points = array_of<float>(xml, "Points", "Float32", 12);
  EXPECT_EQ(points[7], 2);
  EXPECT_EQ(array_of<float>(xml, "Normals", "Float32", 12)[3], 1);
  const auto values = array_of<float>(xml, "Normals_field", "Float32", 4);
  EXPECT_TRUE(std::isnan(values[2]));
  EXPECT_EQ(values[3], 4);
  EXPECT_EQ(array_of<int64_t>(xml, "connectivity", "Int64", 12),
            (std::vector<int64_t>{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}));
  EXPECT_EQ(array_of<int64_t>(xml, "offsets", "Int64", 4), (std::vector<int64_t>{3, 6, 9, 12}));
  EXPECT_NE(xml.find("location=\"vtkDataArray\">&lt;m/s&gt; &amp; \"s\"</InformationKey>"),
            std::string::npos);
  EXPECT_TRUE(xml.ends_with("\n</AppendedData>\n</VTKFile>\n"));
}

TEST_F(VtpFiles, HavePointsInDoublePrecisionWhereNeeded) {
  const Vec3d far{400000.25, 5000000.5, 0};
  const VolumeGrid grid{.voxels = {10, 10, 10}, .spacing = {0.01, 0.01, 0.01}, .origin = far};
  const std::string xml = write("a.vtp", tetrahedron(far), grid, SurfaceContent::points);
  EXPECT_EQ(array_of<double>(xml, "Points", "Float64", 12)[1], far.y);
  EXPECT_EQ(array_of<int64_t>(xml, "connectivity", "Int64", 4), (std::vector<int64_t>{0, 1, 2, 3}));
  EXPECT_EQ(array_of<int64_t>(xml, "offsets", "Int64", 4), (std::vector<int64_t>{1, 2, 3, 4}));
}

/// More numbers than are converted together.
TEST_F(VtpFiles, HoldManyPoints) {
  std::array<MeshPart, 1> part;
  const size_t count = 150'000;
  part[0].vertices.positions.resize(count);
  part[0].vertices.normals.resize(count);
  const std::string xml = write("a.vtp", part, {{2, 2, 2}}, SurfaceContent::points);
  const auto vertices = array_of<int64_t>(xml, "connectivity", "Int64", count);
  const auto offsets = array_of<int64_t>(xml, "offsets", "Int64", count);
  for (size_t i = 0; i < count; ++i) {
    ASSERT_EQ(vertices[i], static_cast<int64_t>(i));
    ASSERT_EQ(offsets[i], static_cast<int64_t>(i + 1));
  }
}

}  // namespace
}  // namespace isosplat
