#include "native/import/array_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "native/import/formats.h"

namespace isosplat {
namespace {

class ArraySource : public VolumeSource {
 public:
  ArraySource(ArrayVolume volume, Orientation orientation, std::unique_ptr<ByteReader> reader)
      : volume_(std::move(volume)),
        reverse_rows_(orientation.reverse_rows),
        reader_(std::move(reader)) {
    header_ = {orientation.grid, volume_.stored.type,  volume_.format,
               volume_.name,     volume_.stored.slope, volume_.stored.intercept};
  }

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const auto nx = static_cast<size_t>(volume_.voxels.x);
    const auto ny = static_cast<size_t>(volume_.voxels.y);
    const size_t slice = nx * ny * voxel_bytes(header_.type);
    if (first < 0 || count < 1 || int64_t{first} + count > volume_.voxels.z ||
        out.size() != slice * static_cast<size_t>(count)) {
      return fail(Status::invalid_argument, "slices outside the volume were asked for");
    }
    const uint64_t offset = volume_.offset + static_cast<uint64_t>(first) * slice;
    if (auto r = reader_->read(offset, out); !r) return r;
    to_native_order(volume_.stored, out);
    if (reverse_rows_) {
      for (size_t z = 0; z < static_cast<size_t>(count); ++z) {
        reverse_rows(out.subspan(z * slice, slice), nx * voxel_bytes(header_.type));
      }
    }
    return {};
  }

  uint64_t resident_bytes() const override { return 0; }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files = reader_->files();
    const std::filesystem::path header = volume_.path;
    if (std::ranges::find(files, header) == files.end()) files.push_back(header);
    return files;
  }

 private:
  ArrayVolume volume_;
  bool reverse_rows_;
  std::unique_ptr<ByteReader> reader_;
  VolumeHeader header_;
};

}  // namespace

ArrayVolume make_array(std::string format, const std::filesystem::path& path,
                       std::span<const int64_t> sizes, const HeaderGeometry& geometry,
                       const ImportOptions& options) {
  ArrayVolume array;
  array.format = std::move(format);
  array.name = volume_name(path);
  array.path = path.string();
  array.voxels = {sizes[0], sizes[1], sizes[2]};
  array.geometry = geometry;
  if (options.spacing) array.geometry.spacing = *options.spacing;
  return array;
}

Result<ArrayVolume> make_array(std::string format, const std::filesystem::path& path,
                               const ItkHeader& header, std::string_view type,
                               const ImportOptions& options) {
  if (header.components != 1) return not_scalar(path, header.components);
  if (!header.has_known_type) return unknown_type(path, type);
  const auto step = choose_time_step(path, header.sizes, options);
  if (!step) return tl::unexpected(step.error());
  ArrayVolume array = make_array(std::move(format), path, header.sizes, header.geometry, options);
  array.stored.type = header.type;
  array.time_step = *step;
  return array;
}

Result<OpenVolume> open_array(ArrayVolume volume, std::unique_ptr<ByteReader> reader,
                              std::vector<std::string> notes) {
  auto orientation = orient(volume.voxels, volume.geometry);
  if (!orientation) {
    return fail(orientation.error().status, volume.path + ": " + orientation.error().message);
  }
  const uint64_t needed = volume_bytes(volume.voxels, voxel_bytes(volume.stored.type));
  const uint64_t limit = reader->size_limit();
  uint64_t skipped = 0;
  if (__builtin_mul_overflow(needed, volume.time_step, &skipped) ||
      __builtin_add_overflow(volume.offset, skipped, &volume.offset)) {
    volume.offset = std::numeric_limits<uint64_t>::max();
  }
  if (volume.offset > limit || needed > limit - volume.offset) {
    const uint64_t found = limit - std::min(limit, volume.offset);
    return fail(
        Status::truncated,
        fmt::format("{}: expected {} bytes of voxels ({} × {} × {}, {} bytes each), found {}{}: "
                    "the file is incomplete, or its header is wrong; copy or download it again",
                    volume.path, needed, volume.voxels.x, volume.voxels.y, volume.voxels.z,
                    voxel_bytes(volume.stored.type), volume.plain ? "" : "at most ", found));
  }
  for (std::string& note : orientation->notes) notes.push_back(std::move(note));
  return OpenVolume{
      std::make_unique<ArraySource>(std::move(volume), std::move(*orientation), std::move(reader)),
      std::move(notes)};
}

uint64_t offset_from_end(uint64_t file_bytes, std::span<const int64_t> sizes, size_t voxel_bytes) {
  uint64_t bytes = voxel_bytes;
  for (const int64_t size : sizes) {
    if (__builtin_mul_overflow(bytes, static_cast<uint64_t>(size), &bytes)) return file_bytes;
  }
  return bytes <= file_bytes ? file_bytes - bytes : file_bytes;
}

void reverse_rows(std::span<std::byte> slice, size_t row_bytes) {
  const size_t rows = slice.size() / row_bytes;
  for (size_t y = 0; y < rows / 2; ++y) {
    std::byte* a = slice.data() + y * row_bytes;
    std::swap_ranges(a, a + row_bytes, slice.data() + (rows - 1 - y) * row_bytes);
  }
}

uint64_t volume_bytes(Vec3<int64_t> voxels, size_t voxel_bytes) {
  return static_cast<uint64_t>(voxels.x) * static_cast<uint64_t>(voxels.y) *
         static_cast<uint64_t>(voxels.z) * voxel_bytes;
}

}  // namespace isosplat
