#pragma once

#include <archive.h>
#include <archive_entry.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "native/extract/mesh_file.h"
#include "tests/native/temporary_folder.h"

// Files of a tetrahedron in two parts, and their parts.
namespace isosplat {

inline std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The second part refers to vertices of the first one. One vertex has no normal.
inline std::array<MeshPart, 2> tetrahedron(Vec3d at = {}) {
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
  std::string write(const char* name, const Parts& parts, const VolumeGrid& grid = {{2, 2, 2}},
                    SurfaceContent content = SurfaceContent::triangles,
                    std::span<const FieldColumn> fields = {}) {
    const auto format = mesh_format(path(name), content);
    EXPECT_TRUE(format);
    auto file = (*format)->create(path(name),
                                  {grid, 1.5, "isosurface 1 of <a> & b\xFC", content, {}, fields});
    EXPECT_TRUE(file);
    for (const MeshPart& part : parts) {
      const auto appended = (*file)->append(part);
      EXPECT_TRUE(appended) << appended.error().message;
    }
    EXPECT_FALSE(std::filesystem::exists(path(name)));
    const auto published = (*file)->publish();
    EXPECT_TRUE(published) << published.error().message;
    std::string bytes = content_of(path(name));
    EXPECT_EQ(bytes.size(), (*file)->bytes());
    EXPECT_TRUE(bytes.starts_with((*format)->beginning));
    return bytes;
  }

  /// The content of a file of a tetrahedron, nothing, and a tetrahedron elsewhere.
  std::string write_objects(const char* name) {
    const std::array<MeshObject, 3> objects{{{"first <one>", {1, 0, 0}, 1, {{2, 2, 2}}},
                                             {"empty", {0, 1, 0}, 1, {{2, 2, 2}}},
                                             {"Sch\u00e4del \"2\"", {0, 0, 1}, 0.5f, {{2, 2, 2}}}}};
    const auto format = mesh_format(path(name), SurfaceContent::triangles);
    EXPECT_TRUE((*format)->has_objects);
    auto file = (*format)->create(
        path(name), {objects[0].grid, 1.5, "isosurfaces", SurfaceContent::triangles, objects});
    EXPECT_TRUE(file);
    for (const Vec3d at : {Vec3d{}, Vec3d{7, 0, 0}}) {
      for (const MeshPart& part : tetrahedron(at)) EXPECT_TRUE((*file)->append(part));
      if (at.x > 0) break;
      EXPECT_TRUE((*file)->next_object());
      EXPECT_TRUE((*file)->next_object());
    }
    EXPECT_TRUE((*file)->publish());
    return content_of(path(name));
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
inline Glb parse_glb(const std::string& content) {
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

/// The files of a ZIP archive, by name.
inline std::map<std::string, std::string> unzip(const std::string& content) {
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

}  // namespace isosplat
