#include "native/extract/ply_file.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>

namespace isosplat {

static_assert(std::endian::native == std::endian::little, "the file is written as it is in memory");

Result<PlyFile> PlyFile::create(const std::filesystem::path& path, std::string_view comment) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  std::string one_line(comment);
  for (char& c : one_line) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  PlyFile ply(std::move(*file), std::move(one_line));
  ply.end_ = ply.header().size();
  return ply;
}

std::string PlyFile::header() const {
  // The count has a fixed width, so that the header can be written last. PLY allows leading zeros,
  // and readers take them; blanks they would not.
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {:020}\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\nend_header\n",
      comment_, points_);
}

Result<void> PlyFile::append(const PointArrays& points) {
  const size_t count = points.positions.size();
  buffer_.resize(count * 24);
  for (size_t i = 0; i < count; ++i) {
    std::memcpy(&buffer_[24 * i], &points.positions[i], 12);
    std::memcpy(&buffer_[24 * i + 12], &points.normals[i], 12);
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
