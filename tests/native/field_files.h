#pragma once

#include <array>
#include <cstring>
#include <vector>

#include "tests/native/cli_program.h"

namespace isosplat::test {

/// The properties of each vertex of a binary PLY file: position, normal, field.
inline std::vector<std::array<float, 7>> vertices_of(const std::string& path) {
  const std::string text = read_file(path);
  const size_t begin = text.find("end_header\n") + 11, named = text.find("element vertex ");
  if (named == text.npos) return {};
  std::vector<std::array<float, 7>> vertices(std::stoul(text.substr(named + 15, 20)));
  if (begin + vertices.size() * sizeof vertices[0] > text.size()) return {};
  std::memcpy(vertices.data(), &text[begin], vertices.size() * sizeof vertices[0]);
  return vertices;
}

/// A cube of n³ voxels of an edge length, whose values are 10 · x in the world.
inline std::string write_ramp(const TempFolder& folder, const std::string& name, int n,
                              double spacing, const std::string& origin) {
  const std::string path = folder / name;
  write_file(path,
             fmt::format("NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\n"
                         "sizes: {0} {0} {0}\nspace directions: ({1},0,0) (0,{1},0) (0,0,{1})\n"
                         "space origin: ({2},{2},{2})\nencoding: raw\nendian: little\n\n",
                         n, spacing, origin) +
                 cube<float>(n, [&](int i) { return 10 * (std::stod(origin) + i % n * spacing); }));
  return path;
}

}  // namespace isosplat::test
