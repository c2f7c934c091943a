#include "shared/core/mesh_files/stl_encoder.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "shared/core/base/vec3.h"

namespace isosplat {

static_assert(std::endian::native == std::endian::little, "the file has the layout of memory");

namespace {

constexpr size_t kHeaderBytes = 84, kTriangleBytes = 50;

/// A triangle of the file: its normal, its corners, and two bytes that are 0.
struct StlTriangle {
  Vec3f normal;
  std::array<Vec3f, 3> corners;
};
static_assert(sizeof(StlTriangle) == 48);

Vec3f unit_normal(const std::array<Vec3f, 3>& corners) {
  const Vec3f normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
  const float size = length(normal);
  return size > 0 ? normal * (1 / size) : Vec3f{};
}

}  // namespace

Result<void> StlEncoder::append(const MeshPart& part, EncodedPart& out) {
  for (const Vec3d& at : part.vertices.positions) {
    positions_.push_back(
        {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)});
  }
  triangles_ += part.triangles.size();
  if (triangles_ > std::numeric_limits<uint32_t>::max()) {
    return fail(Status::invalid_argument,
                "expected at most 2^32 - 1 triangles, which STL files can hold, found more: choose "
                "PLY or a coarser level");
  }
  const size_t begin = out.body.size();
  out.body.resize(begin + part.triangles.size() * kTriangleBytes);
  for (size_t i = 0; i < part.triangles.size(); ++i) {
    StlTriangle triangle;
    for (size_t k = 0; k < 3; ++k) triangle.corners[k] = positions_[part.triangles[i][k]];
    triangle.normal = unit_normal(triangle.corners);
    std::memcpy(&out.body[begin + i * kTriangleBytes], &triangle, sizeof triangle);
  }
  return {};
}

size_t StlEncoder::header_bytes() const {
  return kHeaderBytes;
}

std::vector<std::byte> StlEncoder::header() const {
  std::vector<std::byte> header(kHeaderBytes);
  // Programs would read a file that begins with "solid" as a text file.
  const std::string text = comment_.starts_with("solid") ? " " + comment_ : comment_;
  std::memcpy(header.data(), text.data(), std::min<size_t>(text.size(), 80));
  const auto count = static_cast<uint32_t>(triangles_);
  std::memcpy(&header[80], &count, 4);
  return header;
}

}  // namespace isosplat
