#include "native/extract/glb_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "shared/points/position_precision.h"

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

Result<GlbFile> GlbFile::create(const std::filesystem::path& path, const VolumeGrid& grid,
                                std::string_view comment) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  auto triangles = SpooledBytes::create(path.parent_path());
  if (!triangles) return tl::unexpected(triangles.error());
  const Vec3d middle = grid.world({0.5 * grid.voxels.x, 0.5 * grid.voxels.y, 0.5 * grid.voxels.z});
  GlbFile glb(std::move(*file), std::move(*triangles), needs_doubles(grid) ? middle : Vec3d{},
              comment.substr(0, 300));
  glb.end_ = kDataBegin;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  glb.low_ = {kInfinity, kInfinity, kInfinity};
  glb.high_ = {-kInfinity, -kInfinity, -kInfinity};
  return glb;
}

Result<void> GlbFile::append(const MeshPart& part) {
  const size_t count = part.vertices.positions.size();
  vertices_ += count;
  const uint64_t triangle_bytes = triangles_.size() + part.triangles.size() * kTriangleBytes;
  if (kDataBegin + vertices_ * kVertexBytes + triangle_bytes >
      std::numeric_limits<uint32_t>::max()) {
    return fail(Status::invalid_argument,
                "expected a mesh of less than 4 GiB, the most that a GLB file can hold, found "
                "more: choose .ply, a coarser --level or --simplify");
  }
  buffer_.resize(count * kVertexBytes);
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
    std::memcpy(&buffer_[i * kVertexBytes], &vertex, kVertexBytes);
  }
  if (auto written = file_.write(end_, buffer_); !written) return written;
  end_ += buffer_.size();
  return triangles_.append(std::as_bytes(std::span(part.triangles)));
}

std::string GlbFile::scene() const {
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
                         {"count", triangles_.size() / 4},
                         {"type", "SCALAR"}}};
  scene["bufferViews"] = {{{"buffer", 0},
                           {"byteLength", vertex_bytes},
                           {"byteStride", kVertexBytes},
                           {"target", kArrayBuffer}},
                          {{"buffer", 0},
                           {"byteOffset", vertex_bytes},
                           {"byteLength", triangles_.size()},
                           {"target", kElementBuffer}}};
  scene["buffers"] = {{{"byteLength", vertex_bytes + triangles_.size()}}};
  return to_text(scene);
}

Result<void> GlbFile::publish() {
  auto copied = triangles_.read([&](std::span<const std::byte> piece) {
    auto written = file_.write(end_, piece);
    end_ += piece.size();
    return written;
  });
  if (!copied) return copied;
  std::string text = scene();
  text.resize(kJsonBytes, ' ');
  std::vector<std::byte> header(kDataBegin);
  const auto put = [&](size_t offset, uint32_t number) {
    std::memcpy(&header[offset], &number, 4);
  };
  std::memcpy(header.data(), "glTF", 4);
  put(4, 2);
  put(8, static_cast<uint32_t>(end_));
  put(12, kJsonBytes);
  put(16, kJsonChunk);
  std::memcpy(&header[20], text.data(), kJsonBytes);
  put(20 + kJsonBytes, static_cast<uint32_t>(end_ - kDataBegin));
  put(24 + kJsonBytes, kBinaryChunk);
  // A file without vertices has no binary chunk.
  if (end_ == kDataBegin) {
    header.resize(kDataBegin - 8);
    end_ = header.size();
    put(8, static_cast<uint32_t>(end_));
  }
  if (auto written = file_.write(0, header); !written) return written;
  return file_.publish();
}

}  // namespace isosplat
