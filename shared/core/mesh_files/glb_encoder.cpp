#include "shared/core/mesh_files/glb_encoder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "shared/core/points/position_precision.h"

namespace isosplat {

static_assert(std::endian::native == std::endian::little, "the file has the layout of memory");

namespace {

// The file (glTF 2.0 specification, section 4):
//   0          "glTF", version 2, length of the file
//   12         length and type of the JSON chunk, then its text, filled up with blanks
//   12 + 8 + kJsonBytes   length and type of the binary chunk
//   kDataBegin            vertices of 24 bytes, then triangles of 12 bytes
constexpr uint32_t kJsonBytes = 4096;
constexpr uint64_t kDataBegin = 12 + 8 + kJsonBytes + 8;
constexpr uint32_t kVertexBytes = 24, kTriangleBytes = 12;
constexpr uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;

struct GlbVertex {
  Vec3f position, normal;
};
static_assert(sizeof(GlbVertex) == kVertexBytes);

nlohmann::json to_json(Vec3f v) {
  return {v.x, v.y, v.z};
}

/// Bytes that are not UTF-8 are replaced: file names may have any.
std::string to_text(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

GlbEncoder::GlbEncoder(const VolumeGrid& grid, std::string_view comment)
    : comment_(comment.substr(0, 300)) {
  if (needs_doubles(grid)) {
    offset_ = grid.world({0.5 * grid.voxels.x, 0.5 * grid.voxels.y, 0.5 * grid.voxels.z});
  }
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  low_ = {kInfinity, kInfinity, kInfinity};
  high_ = {-kInfinity, -kInfinity, -kInfinity};
}

Result<void> GlbEncoder::append(const MeshPart& part, EncodedPart& out) {
  const size_t count = part.vertices.positions.size();
  vertices_ += count;
  triangles_ += part.triangles.size();
  if (kDataBegin + vertices_ * kVertexBytes + triangles_ * kTriangleBytes >
      std::numeric_limits<uint32_t>::max()) {
    return fail(Status::invalid_argument,
                "expected a mesh of less than 4 GiB, the most that a GLB file can hold, found "
                "more: choose PLY, a coarser level, or fewer triangles");
  }
  const size_t begin = out.body.size();
  out.body.resize(begin + count * kVertexBytes);
  for (size_t i = 0; i < count; ++i) {
    const Vec3d at = part.vertices.positions[i] - offset_;
    Vec3f normal = part.vertices.normals[i];
    // glTF demands unit vectors, also where the volume has no gradient.
    if (normal.x == 0 && normal.y == 0 && normal.z == 0) normal.z = 1;
    const GlbVertex vertex{
        {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)}, normal};
    const Vec3f p = vertex.position;
    low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y), std::min(low_.z, p.z)};
    high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y), std::max(high_.z, p.z)};
    std::memcpy(&out.body[begin + i * kVertexBytes], &vertex, kVertexBytes);
  }
  const auto triangles = std::as_bytes(std::span(part.triangles));
  out.tail.insert(out.tail.end(), triangles.begin(), triangles.end());
  return {};
}

std::string GlbEncoder::scene() const {
  using nlohmann::json;
  json scene = {{"asset", {{"version", "2.0"}, {"generator", comment_}}}, {"scene", 0}};
  scene["scenes"] = {{{"nodes", json::array({0})}}};
  // A quarter turn about x takes z up to y up.
  scene["nodes"] = {{{"name", "millimetres, LPS"},
                     {"rotation", {-std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)}},
                     {"scale", {0.001, 0.001, 0.001}}}};
  if (vertices_ == 0) return to_text(scene);
  scene["nodes"][0]["children"] = json::array({1});
  scene["nodes"].push_back({{"mesh", 0}, {"translation", {offset_.x, offset_.y, offset_.z}}});
  scene["materials"] = {{{"doubleSided", true},
                         {"pbrMetallicRoughness",
                          {{"baseColorFactor", {0.69, 0.64, 0.53, 1.0}},
                           {"metallicFactor", 0.0},
                           {"roughnessFactor", 0.5}}}}};
  const json attributes = {{"POSITION", 0}, {"NORMAL", 1}};
  scene["meshes"] = {
      {{"primitives", {{{"attributes", attributes}, {"indices", 2}, {"material", 0}}}}}};
  const uint64_t vertex_bytes = vertices_ * kVertexBytes;
  const uint64_t triangle_bytes = triangles_ * kTriangleBytes;
  scene["accessors"] = {{{"bufferView", 0},
                         {"componentType", kFloat},
                         {"count", vertices_},
                         {"type", "VEC3"},
                         {"min", to_json(low_)},
                         {"max", to_json(high_)}},
                        {{"bufferView", 0},
                         {"byteOffset", offsetof(GlbVertex, normal)},
                         {"componentType", kFloat},
                         {"count", vertices_},
                         {"type", "VEC3"}},
                        {{"bufferView", 1},
                         {"componentType", kUnsignedInt},
                         {"count", triangles_ * 3},
                         {"type", "SCALAR"}}};
  scene["bufferViews"] = {{{"buffer", 0},
                           {"byteLength", vertex_bytes},
                           {"byteStride", kVertexBytes},
                           {"target", kArrayBuffer}},
                          {{"buffer", 0},
                           {"byteOffset", vertex_bytes},
                           {"byteLength", triangle_bytes},
                           {"target", kElementBuffer}}};
  scene["buffers"] = {{{"byteLength", vertex_bytes + triangle_bytes}}};
  return to_text(scene);
}

size_t GlbEncoder::header_bytes() const {
  return kDataBegin;
}

std::vector<std::byte> GlbEncoder::header() const {
  std::string text = scene();
  text.resize(kJsonBytes, ' ');
  const uint64_t data = vertices_ * kVertexBytes + triangles_ * kTriangleBytes;
  // A file without vertices has no binary chunk.
  std::vector<std::byte> header(data > 0 ? kDataBegin : kDataBegin - 8);
  const auto put = [&](size_t offset, uint64_t number) {
    const auto word = static_cast<uint32_t>(number);
    std::memcpy(&header[offset], &word, 4);
  };
  std::memcpy(header.data(), "glTF", 4);
  put(4, 2);
  put(8, header.size() + data);
  put(12, kJsonBytes);
  put(16, kJsonChunk);
  std::memcpy(&header[20], text.data(), kJsonBytes);
  if (data > 0) {
    put(20 + kJsonBytes, data);
    put(24 + kJsonBytes, kBinaryChunk);
  }
  return header;
}

}  // namespace isosplat
