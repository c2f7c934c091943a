#include "native/extract/ply_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace isosplat {

static_assert(std::endian::native == std::endian::little, "the file has the layout of memory");

namespace {

/// Whether single precision would move a point of the volume by more than 1/2000 of a voxel.
bool needs_doubles(const VolumeGrid& grid) {
  double farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at = grid.world({corner & 1 ? double(grid.voxels.x) : -1.0,
                                 corner & 2 ? double(grid.voxels.y) : -1.0,
                                 corner & 4 ? double(grid.voxels.z) : -1.0});
    farthest = std::max({farthest, std::abs(at.x), std::abs(at.y), std::abs(at.z)});
  }
  const double voxel = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  return !(std::ldexp(farthest, -24) <= voxel / 2000);
}

}  // namespace

Result<PlyFile> PlyFile::create(const std::filesystem::path& path, const VolumeGrid& grid,
                                std::string_view comment) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  std::string one_line(comment);
  for (char& c : one_line) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  PlyFile ply(std::move(*file), needs_doubles(grid), std::move(one_line));
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
      "property float nx\nproperty float ny\nproperty float nz\nend_header\n",
      comment_, points_, type, type, type);
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

Result<void> PlyFile::publish() {
  const std::string text = header();
  if (auto written = file_.write(0, std::as_bytes(std::span(text))); !written) return written;
  return file_.publish();
}

}  // namespace isosplat
