#include "native/extract/ply_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "shared/points/position_precision.h"

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

}  // namespace

Result<PlyFile> PlyFile::create(const std::filesystem::path& path, const VolumeGrid& grid,
                                std::string_view comment, Content content) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  std::string one_line(comment);
  for (char& c : one_line) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  PlyFile ply(std::move(*file), needs_doubles(grid), std::move(one_line));
  if (content == Content::triangles) {
    auto spooled = SpooledBytes::create(path.parent_path());
    if (!spooled) return tl::unexpected(spooled.error());
    ply.spooled_ = std::move(*spooled);
  }
  ply.end_ = ply.header().size();
  return ply;
}

std::string PlyFile::header() const {
  // The count has a fixed width, so that the header can be written last. PLY readers accept leading
  // zeros, but not blanks.
  const char* type = doubles_ ? "double" : "float";
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {:020}\n"
      "property {} x\nproperty {} y\nproperty {} z\n"
      "property float nx\nproperty float ny\nproperty float nz\n{}end_header\n",
      comment_, points_, type, type, type,
      spooled_ ? fmt::format("element face {:020}\n"
                             "property list uchar uint vertex_indices\n",
                             triangles_)
               : "");
}

Result<void> PlyFile::append(const PointArrays& points) {
  const size_t count = points.positions.size();
  const size_t position_bytes = doubles_ ? 24 : 12, point_bytes = position_bytes + 12;
  buffer_.resize(count * point_bytes);
  for (size_t i = 0; i < count; ++i) {
    const Vec3d& at = points.positions[i];
    std::byte* const to = &buffer_[point_bytes * i];
    if (doubles_) {
      std::memcpy(to, &at, 24);
    } else {
      const Vec3f rounded{static_cast<float>(at.x), static_cast<float>(at.y),
                          static_cast<float>(at.z)};
      std::memcpy(to, &rounded, 12);
    }
    std::memcpy(to + position_bytes, &points.normals[i], 12);
  }
  if (auto written = file_.write(end_, buffer_); !written) return written;
  end_ += buffer_.size();
  points_ += count;
  return {};
}

Result<void> PlyFile::append(std::span<const std::array<uint32_t, 3>> triangles) {
  buffer_.resize(triangles.size() * sizeof(Face));
  for (size_t i = 0; i < triangles.size(); ++i) {
    const Face face{3, triangles[i]};
    std::memcpy(&buffer_[i * sizeof(Face)], &face, sizeof(Face));
  }
  auto written = spooled_->append(buffer_);
  if (written) triangles_ += triangles.size();
  return written;
}

Result<void> PlyFile::publish() {
  if (spooled_) {
    auto copied = spooled_->read([&](std::span<const std::byte> piece) {
      auto written = file_.write(end_, piece);
      end_ += piece.size();
      return written;
    });
    if (!copied) return copied;
  }
  const std::string text = header();
  if (auto written = file_.write(0, std::as_bytes(std::span(text))); !written) return written;
  return file_.publish();
}

}  // namespace isosplat
