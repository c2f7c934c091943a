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
//   20 + J     length and type of the binary chunk; J: bytes of the text
//   28 + J     vertices of all objects, of 24 bytes each, then triangles of 12 bytes
// J is fixed before the numbers of vertices and triangles are known, so that the file can be
// written from the first vertex on.
constexpr size_t kSceneBytes = 2048, kObjectBytes = 2048;  // more than their JSON needs
constexpr size_t kMaxNameBytes = 256;
constexpr size_t kTextBegin = 12 + 8, kBinaryHeader = 8;
constexpr uint32_t kVertexBytes = 24, kTriangleBytes = 12;
constexpr uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;
constexpr std::array<float, 4> kPlainColour{0.69f, 0.64f, 0.53f, 1};  // linear

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

/// glTF has colours of linear light (IEC 61966-2-1, the inverse of the transfer function).
float to_linear(float srgb) {
  return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}

Vec3d offset_of(const VolumeGrid& grid) {
  if (!needs_doubles(grid)) return {};
  return grid.world({0.5 * grid.voxels.x, 0.5 * grid.voxels.y, 0.5 * grid.voxels.z});
}

}  // namespace

GlbEncoder::GlbEncoder(const VolumeGrid& grid, std::string_view comment)
    : objects_(1), comment_(comment.substr(0, 300)), json_bytes_(kSceneBytes + kObjectBytes) {
  objects_[0].colour = kPlainColour;
  objects_[0].offset = offset_of(grid);
}

GlbEncoder::GlbEncoder(std::span<const MeshObject> objects, std::string_view comment)
    : comment_(comment.substr(0, 300)), json_bytes_(kSceneBytes) {
  for (const MeshObject& from : objects) {
    Object& object = objects_.emplace_back();
    object.name = from.name.substr(0, kMaxNameBytes);
    object.colour = {to_linear(from.colour[0]), to_linear(from.colour[1]),
                     to_linear(from.colour[2]), from.opacity};
    object.offset = offset_of(from.grid);
    json_bytes_ += kObjectBytes + 2 * to_text(object.name).size();
  }
  json_bytes_ = (json_bytes_ + 3) / 4 * 4;
}

Result<void> GlbEncoder::append(const MeshPart& part, EncodedPart& out) {
  const size_t count = part.vertices.positions.size();
  vertices_ += count;
  triangles_ += part.triangles.size();
  if (header_bytes() + vertices_ * kVertexBytes + triangles_ * kTriangleBytes >
      std::numeric_limits<uint32_t>::max()) {
    return fail(Status::invalid_argument,
                "expected a mesh of less than 4 GiB, the most that a GLB file can hold, found "
                "more: choose PLY, a coarser level, or fewer triangles");
  }
  Object& object = objects_[open_];
  if (object.vertices == 0 && count > 0) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    object.low = {kInfinity, kInfinity, kInfinity};
    object.high = {-kInfinity, -kInfinity, -kInfinity};
  }
  object.vertices += count;
  object.triangles += part.triangles.size();
  const size_t begin = out.body.size();
  out.body.resize(begin + count * kVertexBytes);
  for (size_t i = 0; i < count; ++i) {
    const Vec3d at = part.vertices.positions[i] - object.offset;
    Vec3f normal = part.vertices.normals[i];
    // glTF demands unit vectors, also where the volume has no gradient.
    if (normal.x == 0 && normal.y == 0 && normal.z == 0) normal.z = 1;
    const GlbVertex vertex{
        {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)}, normal};
    const Vec3f p = vertex.position;
    Vec3f &low = object.low, &high = object.high;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
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
  if (triangles_ == 0) return to_text(scene);
  uint64_t vertex_bytes = 0, triangle_bytes = 0;
  for (const Object& object : objects_) {
    const uint64_t first_vertex = vertex_bytes, first_triangle = triangle_bytes;
    vertex_bytes += object.vertices * kVertexBytes;
    triangle_bytes += object.triangles * kTriangleBytes;
    if (object.triangles == 0) continue;
    const size_t mesh = scene["meshes"].size(), accessor = scene["accessors"].size();
    const Vec3d at = object.offset;
    json node = {{"mesh", mesh}, {"translation", {at.x, at.y, at.z}}};
    json surface = {{"primitives",
                     {{{"attributes", {{"POSITION", accessor}, {"NORMAL", accessor + 1}}},
                       {"indices", accessor + 2},
                       {"material", mesh}}}}};
    json material = {
        {"doubleSided", true},
        {"pbrMetallicRoughness",
         {{"baseColorFactor", object.colour}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.5}}}};
    if (!object.name.empty()) node["name"] = surface["name"] = object.name;
    if (object.colour[3] < 1) material["alphaMode"] = "BLEND";
    scene["nodes"][0]["children"].push_back(mesh + 1);
    scene["nodes"].push_back(node);
    scene["meshes"].push_back(surface);
    scene["materials"].push_back(material);
    scene["accessors"].push_back({{"bufferView", 0},
                                  {"byteOffset", first_vertex},
                                  {"componentType", kFloat},
                                  {"count", object.vertices},
                                  {"type", "VEC3"},
                                  {"min", to_json(object.low)},
                                  {"max", to_json(object.high)}});
    scene["accessors"].push_back({{"bufferView", 0},
                                  {"byteOffset", first_vertex + offsetof(GlbVertex, normal)},
                                  {"componentType", kFloat},
                                  {"count", object.vertices},
                                  {"type", "VEC3"}});
    scene["accessors"].push_back({{"bufferView", 1},
                                  {"byteOffset", first_triangle},
                                  {"componentType", kUnsignedInt},
                                  {"count", object.triangles * 3},
                                  {"type", "SCALAR"}});
  }
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
  return kTextBegin + json_bytes_ + kBinaryHeader;
}

std::vector<std::byte> GlbEncoder::header() const {
  std::string text = scene();
  text.resize(json_bytes_, ' ');
  const uint64_t data = vertices_ * kVertexBytes + triangles_ * kTriangleBytes;
  // A file without vertices has no binary chunk.
  std::vector<std::byte> header(header_bytes() - (data > 0 ? 0 : kBinaryHeader));
  const auto put = [&](size_t offset, uint64_t number) {
    const auto word = static_cast<uint32_t>(number);
    std::memcpy(&header[offset], &word, 4);
  };
  std::memcpy(header.data(), "glTF", 4);
  put(4, 2);
  put(8, header.size() + data);
  put(12, json_bytes_);
  put(16, kJsonChunk);
  std::memcpy(&header[kTextBegin], text.data(), json_bytes_);
  if (data > 0) {
    put(kTextBegin + json_bytes_, data);
    put(kTextBegin + json_bytes_ + 4, kBinaryChunk);
  }
  return header;
}

}  // namespace isosplat
