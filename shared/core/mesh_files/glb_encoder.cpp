#include "shared/core/mesh_files/glb_encoder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
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
//   28 + J     vertices of all objects, of 24 bytes each, then triangles of 12 bytes; then, of each
//              object, the values of its fields, of 4 bytes; and then the colours, of 8 bytes
// J is fixed before the numbers of vertices and triangles are known, so that the file can be
// written from the first vertex on.
constexpr size_t kSceneBytes = 2048, kObjectBytes = 2048;  // more than their JSON needs
constexpr size_t kFieldBytes = 1024;                       // of an object, besides names
constexpr size_t kMaxNameBytes = 256;
constexpr size_t kTextBegin = 12 + 8, kBinaryHeader = 8;
constexpr uint32_t kVertexBytes = 24, kTriangleBytes = 12, kValueBytes = 4, kColourBytes = 8;
constexpr uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125, kUnsignedShort = 5123, kArrayBuffer = 34962,
              kElementBuffer = 34963;
constexpr std::array<float, 4> kPlainColour{0.69f, 0.64f, 0.53f, 1};  // linear
constexpr std::array<uint8_t, 3> kMissingColour{128, 128, 128};       // sRGB
constexpr float kMissingValue = std::numeric_limits<float>::lowest();
constexpr float kLargestValue = std::numeric_limits<float>::max();

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

/// "_" and the name in capital letters, with digits and "_": each one only once.
std::vector<std::string> attribute_names(std::span<const FieldColumn> fields) {
  std::vector<std::string> names;
  for (const FieldColumn& field : fields) {
    std::string name = "_";
    for (const char c : field.name) {
      name += c >= 'a' && c <= 'z'                               ? static_cast<char>(c - 'a' + 'A')
              : (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ? c
                                                                 : '_';
    }
    while (std::find(names.begin(), names.end(), name) != names.end()) name += "_";
    names.push_back(std::move(name));
  }
  return names;
}

/// The 1st and the 99th percentile of numbers; 0 and 0 if there are none. Reorders them.
std::array<float, 2> percentiles(std::vector<float>& numbers) {
  if (numbers.empty()) return {};
  const auto at = [&](double share) {
    const auto nth = numbers.begin() +
                     static_cast<ptrdiff_t>(share * static_cast<double>(numbers.size() - 1) + 0.5);
    std::nth_element(numbers.begin(), nth, numbers.end());
    return *nth;
  };
  return {at(0.01), at(0.99)};
}

Vec3d offset_of(const VolumeGrid& grid) {
  if (!needs_doubles(grid)) return {};
  return grid.world({0.5 * grid.voxels.x, 0.5 * grid.voxels.y, 0.5 * grid.voxels.z});
}

}  // namespace

GlbEncoder::GlbEncoder(const VolumeGrid& grid, std::string_view comment, const GlbFields& fields)
    : objects_(1), comment_(comment.substr(0, 300)), json_bytes_(kSceneBytes + kObjectBytes) {
  objects_[0].colour = kPlainColour;
  objects_[0].offset = offset_of(grid);
  reserve_text(fields);
}

GlbEncoder::GlbEncoder(std::span<const MeshObject> objects, std::string_view comment,
                       const GlbFields& fields)
    : comment_(comment.substr(0, 300)), json_bytes_(kSceneBytes) {
  for (const MeshObject& from : objects) {
    Object& object = objects_.emplace_back();
    object.name = from.name.substr(0, kMaxNameBytes);
    object.colour = {to_linear(from.colour[0]), to_linear(from.colour[1]),
                     to_linear(from.colour[2]), from.opacity};
    object.offset = offset_of(from.grid);
    json_bytes_ += kObjectBytes + 2 * to_text(object.name).size();
  }
  reserve_text(fields);
}

/// Sets the fields, and completes the bytes of the JSON text.
void GlbEncoder::reserve_text(const GlbFields& fields) {
  fields_.assign(fields.columns.begin(), fields.columns.end());
  attributes_ = attribute_names(fields_);
  colour_map_ = fields.colour_map;
  for (FieldColumn& field : fields_) {
    field.title.resize(std::min(field.title.size(), kMaxNameBytes));
    field.units.resize(std::min(field.units.size(), kMaxNameBytes));
    json_bytes_ +=
        objects_.size() * (kFieldBytes + to_text(field.title).size() + to_text(field.units).size());
  }
  for (Object& object : objects_) object.values.resize(fields_.size());
  json_bytes_ = (json_bytes_ + 3) / 4 * 4;
}

Result<void> GlbEncoder::append(const MeshPart& part, EncodedPart& out) {
  const size_t count = part.vertices.positions.size();
  vertices_ += count;
  triangles_ += part.triangles.size();
  const uint64_t field_bytes = fields_.empty() ? 0 : kValueBytes * fields_.size() + kColourBytes;
  if (header_bytes() + vertices_ * (kVertexBytes + field_bytes) + triangles_ * kTriangleBytes >
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
  append_values(object.values, part.vertices.fields);
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

void GlbEncoder::finish(std::vector<std::byte>& out) {
  if (fields_.empty()) return;
  const float lowest = std::nextafter(kMissingValue, 0.0f);
  std::vector<float> known;
  for (Object& object : objects_) {
    for (auto& values : object.values) {
      const bool has_none =
          std::all_of(values.begin(), values.end(), [](float value) { return std::isnan(value); });
      if (has_none) values = {};
      // glTF has no infinities. The lowest number is that of missing values.
      for (float& value : values) value = std::clamp(value, lowest, kLargestValue);
    }
    std::copy_if(object.values[0].begin(), object.values[0].end(), std::back_inserter(known),
                 [](float value) { return !std::isnan(value); });
  }
  coloured_ = percentiles(known);
  const auto append = [&](const auto& value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    out.insert(out.end(), bytes.begin(), bytes.end());
  };
  out.reserve(out.size() + static_cast<size_t>(value_bytes() + colour_bytes()));
  for (const Object& object : objects_) {
    for (const auto& values : object.values) {
      for (const float value : values) append(std::isnan(value) ? kMissingValue : value);
    }
  }
  const auto linear = [](std::array<uint8_t, 3> colour) {
    std::array<uint16_t, 4> result{0, 0, 0, 65535};
    for (size_t i = 0; i < 3; ++i) {
      result[i] = static_cast<uint16_t>(to_linear(colour[i] / 255.0f) * 65535 + 0.5f);
    }
    return result;
  };
  std::vector<std::array<uint16_t, 4>> colours;
  for (const auto& colour : colour_map_) colours.push_back(linear(colour));
  const auto of_missing = linear(kMissingColour);
  const auto last = static_cast<double>(colours.size() - 1);
  const double low = coloured_[0], width = coloured_[1] - low;
  for (const Object& object : objects_) {
    for (const float value : object.values[0]) {
      const double share = width > 0 ? std::clamp((value - low) / width, 0.0, 1.0) : 0.5;
      append(std::isnan(value) ? of_missing : colours[static_cast<size_t>(share * last + 0.5)]);
    }
  }
}

uint64_t GlbEncoder::value_bytes() const {
  uint64_t bytes = 0;
  for (const Object& object : objects_) {
    for (const auto& values : object.values) bytes += kValueBytes * values.size();
  }
  return bytes;
}

uint64_t GlbEncoder::colour_bytes() const {
  uint64_t bytes = 0;
  for (const Object& object : objects_) {
    if (!fields_.empty()) bytes += kColourBytes * object.values[0].size();
  }
  return bytes;
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
  uint64_t vertex_bytes = 0, triangle_bytes = 0, values_before = 0, colours_before = 0;
  for (const Object& object : objects_) {
    const uint64_t first_vertex = vertex_bytes, first_triangle = triangle_bytes;
    vertex_bytes += object.vertices * kVertexBytes;
    triangle_bytes += object.triangles * kTriangleBytes;
    const uint64_t first_value = values_before, first_colour = colours_before;
    for (const auto& values : object.values) values_before += kValueBytes * values.size();
    const bool is_coloured = !fields_.empty() && !object.values[0].empty();
    if (is_coloured) colours_before += kColourBytes * object.vertices;
    if (object.triangles == 0) continue;
    const size_t mesh = scene["meshes"].size();
    const size_t accessor = scene["accessors"].size();
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
    json& attributes = surface["primitives"][0]["attributes"];
    if (is_coloured) {
      attributes["COLOR_0"] = accessor + 3;
      material["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, object.colour[3]};
    }
    const size_t first_field = accessor + 3 + (is_coloured ? 1 : 0);
    json field_accessors = json::array();
    uint64_t value_at = first_value;
    for (size_t i = 0; i < fields_.size(); ++i) {
      if (object.values[i].empty()) continue;
      attributes[attributes_[i]] = first_field + field_accessors.size();
      field_accessors.push_back({{"bufferView", 2},
                                 {"byteOffset", value_at},
                                 {"componentType", kFloat},
                                 {"count", object.vertices},
                                 {"type", "SCALAR"}});
      value_at += kValueBytes * object.vertices;
      json field = {
          {"attribute", attributes_[i]}, {"name", fields_[i].name}, {"missing", kMissingValue}};
      if (!fields_[i].title.empty()) field["title"] = fields_[i].title;
      if (!fields_[i].units.empty()) field["units"] = fields_[i].units;
      if (i == 0) field["coloured"] = coloured_;
      surface["extras"]["fields"].push_back(field);
    }
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
    if (is_coloured) {
      scene["accessors"].push_back({{"bufferView", 3},
                                    {"byteOffset", first_colour},
                                    {"componentType", kUnsignedShort},
                                    {"normalized", true},
                                    {"count", object.vertices},
                                    {"type", "VEC4"}});
    }
    for (json& of_field : field_accessors) scene["accessors"].push_back(std::move(of_field));
  }
  scene["bufferViews"] = {{{"buffer", 0},
                           {"byteLength", vertex_bytes},
                           {"byteStride", kVertexBytes},
                           {"target", kArrayBuffer}},
                          {{"buffer", 0},
                           {"byteOffset", vertex_bytes},
                           {"byteLength", triangle_bytes},
                           {"target", kElementBuffer}}};
  const uint64_t before_values = vertex_bytes + triangle_bytes;
  const auto add_view = [&](uint64_t offset, uint64_t bytes, uint32_t stride) {
    scene["bufferViews"].push_back({{"buffer", 0},
                                    {"byteOffset", offset},
                                    {"byteLength", bytes},
                                    {"byteStride", stride},
                                    {"target", kArrayBuffer}});
  };
  if (values_before > 0) add_view(before_values, values_before, kValueBytes);
  if (colours_before > 0) add_view(before_values + values_before, colours_before, kColourBytes);
  scene["buffers"] = {{{"byteLength", before_values + values_before + colours_before}}};
  return to_text(scene);
}

size_t GlbEncoder::header_bytes() const {
  return kTextBegin + json_bytes_ + kBinaryHeader;
}

std::vector<std::byte> GlbEncoder::header() const {
  std::string text = scene();
  text.resize(json_bytes_, ' ');
  const uint64_t data =
      vertices_ * kVertexBytes + triangles_ * kTriangleBytes + value_bytes() + colour_bytes();
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
