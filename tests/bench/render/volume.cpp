#include "tests/bench/render/volume.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "shared/import/open_volume.h"

namespace isosplat {
namespace {

[[noreturn]] void give_up(const std::string& why) {
  std::fprintf(stderr, "%s\n", why.c_str());
  std::exit(1);
}

}  // namespace

TestVolume load_volume(const std::string& path) {
  auto opened = import::open_volume(path, {});
  if (!opened) give_up(opened.error().message);
  VolumeSource& source = *opened->source;
  const VolumeHeader& header = source.header();
  const Index3 n = header.grid.voxels;
  const size_t voxels = size_t(n.x) * size_t(n.y) * size_t(n.z);
  std::vector<std::byte> bytes(voxels * voxel_bytes(header.type));
  if (const auto read = source.read_slices(0, n.z, bytes); !read) give_up(read.error().message);
  TestVolume volume;
  volume.grid = header.grid;
  volume.quantized_values.resize(voxels);
  for (size_t i = 0; i < voxels; ++i) {
    switch (header.type) {
      case VoxelType::u8:
        volume.quantized_values[i] = static_cast<QuantizedValue>(bytes[i]);
        break;
      case VoxelType::u16:
        std::memcpy(&volume.quantized_values[i], &bytes[2 * i], 2);
        break;
      case VoxelType::i16: {
        int16_t value;
        std::memcpy(&value, &bytes[2 * i], 2);
        volume.quantized_values[i] = static_cast<QuantizedValue>(value + 32768);
        break;
      }
      default:
        give_up(path + ": only volumes of 8 and 16 bits here");
    }
  }
  if (header.type == VoxelType::i16) volume.mapping.offset = -32768;
  return volume;
}

uint64_t show_mesh(render::Renderer& renderer, const VolumeGrid& grid, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  uint64_t counts[2] = {0, 0};
  file.read(reinterpret_cast<char*>(counts), 16);
  std::vector<Vec3f> positions(counts[0]), normals(counts[0]);
  std::vector<uint32_t> triangles(3 * counts[1]);
  const auto read = [&](auto& list) {
    file.read(reinterpret_cast<char*>(list.data()),
              static_cast<std::streamsize>(list.size() * sizeof(list[0])));
  };
  read(positions);
  read(normals);
  read(triangles);
  if (!file) give_up(path + ": not a mesh file");
  const Matrix3d dual = inverse_transpose(grid.direction);
  const auto turned = [&](const Matrix3d& by, Vec3f v) {
    return multiply(by, {double(v.x), double(v.y), double(v.z)});
  };
  const auto single = [](Vec3d v) {
    return Vec3f{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
  };
  const Vec3d shift = grid.origin - render::bounding_sphere(grid).centre;
  std::vector<render::MeshVertex> vertices(counts[0]);
  for (size_t i = 0; i < vertices.size(); ++i) {
    vertices[i] = {single(turned(grid.direction, positions[i]) + shift),
                   single(turned(dual, normals[i]))};
  }
  if (const auto set = renderer.set_mesh(vertices, triangles); !set) give_up(set.error().message);
  return counts[1];
}

}  // namespace isosplat
