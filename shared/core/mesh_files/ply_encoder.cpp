#include "shared/core/mesh_files/ply_encoder.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <span>

#include "shared/core/points/position_precision.h"

namespace isosplat {

static_assert(std::endian::native == std::endian::little, "the file has the layout of memory");

namespace {

#pragma pack(push, 1)
/// A triangle as "property list uchar uint vertex_indices".
struct Face {
  uint8_t count = 3;
  std::array<uint32_t, 3> vertices;
};
#pragma pack(pop)
static_assert(sizeof(Face) == 13);

/// The text has a fixed width, so that the header can be written last. PLY readers accept leading
/// zeros, but not blanks.
std::string count_text(uint64_t count) {
  const std::string digits = std::to_string(count);
  return std::string(20 - digits.size(), '0') + digits + "\n";
}

/// A line of the header.
std::string comment_line(std::string_view text) {
  std::string line = "comment ";
  for (const char c : text) line += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  return line + "\n";
}

constexpr std::array<std::string_view, 6> kProperties{"x", "y", "z", "nx", "ny", "nz"};

}  // namespace

PlyEncoder::PlyEncoder(const VolumeGrid& grid, std::string_view comment, Content content,
                       std::span<const FieldColumn> fields)
    : has_doubles_(needs_doubles(grid)),
      content_(content),
      comments_(comment_line(comment)),
      fields_(column_names(fields, kProperties)) {
  for (const FieldColumn& field : fields) comments_ += comment_line(description_of(field));
}

std::vector<std::byte> PlyEncoder::header() const {
  const std::string property = has_doubles_ ? "property double " : "property float ";
  std::string text = "ply\nformat binary_little_endian 1.0\n" + comments_ + "element vertex " +
                     count_text(points_);
  for (const char* name : {"x\n", "y\n", "z\n"}) text += property + name;
  text += "property float nx\nproperty float ny\nproperty float nz\n";
  for (const std::string& name : fields_) text += "property float " + name + "\n";
  if (content_ == Content::triangles) {
    text += "element face " + count_text(triangles_) + "property list uchar uint vertex_indices\n";
  }
  text += "end_header\n";
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Result<void> PlyEncoder::append(const MeshPart& part, EncodedPart& out) {
  const PointsWithFields& points = part.vertices;
  const size_t count = points.positions.size(), vertices_begin = out.body.size();
  const size_t position_bytes = has_doubles_ ? 24 : 12, fields_begin = position_bytes + 12;
  const size_t point_bytes = fields_begin + 4 * fields_.size();
  out.body.resize(vertices_begin + count * point_bytes);
  for (size_t i = 0; i < count; ++i) {
    const Vec3d& at = points.positions[i];
    std::byte* const to = &out.body[vertices_begin + point_bytes * i];
    if (has_doubles_) {
      std::memcpy(to, &at, 24);
    } else {
      const Vec3f rounded{static_cast<float>(at.x), static_cast<float>(at.y),
                          static_cast<float>(at.z)};
      std::memcpy(to, &rounded, 12);
    }
    std::memcpy(to + position_bytes, &points.normals[i], 12);
    for (size_t field = 0; field < fields_.size(); ++field) {
      std::memcpy(to + fields_begin + 4 * field, &points.fields[field][i], 4);
    }
  }
  points_ += count;
  if (content_ == Content::points) return {};
  const size_t faces_begin = out.tail.size();
  out.tail.resize(faces_begin + part.triangles.size() * sizeof(Face));
  for (size_t i = 0; i < part.triangles.size(); ++i) {
    const Face face{3, part.triangles[i]};
    std::memcpy(&out.tail[faces_begin + i * sizeof(Face)], &face, sizeof(Face));
  }
  triangles_ += part.triangles.size();
  return {};
}

}  // namespace isosplat
