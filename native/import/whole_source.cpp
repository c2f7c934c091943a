#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "native/import/array_source.h"
#include "native/import/formats.h"

namespace isosplat {
namespace {

class WholeSource : public VolumeSource {
 public:
  WholeSource(ItkFormat format, ItkHeader itk_header, VolumeHeader header, bool reverse,
              std::string path, uint64_t bytes, uint64_t skipped,
              std::vector<std::filesystem::path> data_files, uint64_t memory_bytes)
      : format_(format),
        itk_header_(std::move(itk_header)),
        header_(std::move(header)),
        reverse_(reverse),
        path_(std::move(path)),
        bytes_(bytes),
        skipped_(skipped),
        data_files_(std::move(data_files)),
        memory_bytes_(memory_bytes) {}

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const Index3 n = header_.grid.voxels;
    const size_t row = static_cast<size_t>(n.x) * voxel_bytes(header_.type);
    const size_t slice = static_cast<size_t>(n.y) * row;
    if (first < 0 || count < 1 || int64_t{first} + count > n.z ||
        out.size() != slice * static_cast<size_t>(count)) {
      return fail(Status::invalid_argument, "slices outside the volume were asked for");
    }
    if (voxels_.empty()) {
      if (auto r = read_all(); !r) return r;
    }
    std::copy_n(voxels_.data() + skipped_ + static_cast<size_t>(first) * slice, out.size(),
                out.data());
    for (int32_t z = 0; reverse_ && z < count; ++z) {
      reverse_rows(out.subspan(static_cast<size_t>(z) * slice, slice), row);
    }
    return {};
  }

  uint64_t resident_bytes() const override { return bytes_; }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files = data_files_;
    files.emplace_back(path_);
    return files;
  }

 private:
  Result<void> read_all() {
    try {
      voxels_.resize(static_cast<size_t>(bytes_));
    } catch (const std::bad_alloc&) {
      return fail(Status::out_of_memory,
                  fmt::format("{}: this format can only be read whole, which needs {} bytes of "
                              "memory: save the volume as uncompressed NRRD, which is streamed",
                              path_, bytes_));
    }
    auto read = read_itk_voxels(format_, path_, itk_header_, memory_bytes_, voxels_);
    if (!read) voxels_.clear();
    return read;
  }

  ItkFormat format_;
  ItkHeader itk_header_;
  VolumeHeader header_;
  bool reverse_;
  std::string path_;
  uint64_t bytes_;                                 ///< of all voxels of all time steps
  uint64_t skipped_;                               ///< of the time steps before the one wanted
  std::vector<std::filesystem::path> data_files_;  ///< beside the file itself
  uint64_t memory_bytes_;                          ///< that reading may take beside `bytes_`
  std::vector<std::byte> voxels_;
};

}  // namespace

Result<OpenVolume> open_whole(ItkFormat itk_format, const ItkHeader& header, std::string format,
                              const std::filesystem::path& path, const ImportOptions& options,
                              std::vector<std::filesystem::path> data_files) {
  if (header.components != 1) return not_scalar(path, header.components);
  if (!header.has_known_type) return unknown_type(path, "unknown");
  const auto step = choose_time_step(path, header.sizes, options);
  if (!step) return tl::unexpected(step.error());

  OpenVolume volume;
  HeaderGeometry geometry = header.geometry;
  if (options.spacing) geometry.spacing = *options.spacing;
  const Vec3<int64_t> voxels{header.sizes[0], header.sizes[1], header.sizes[2]};
  auto orientation = orient(voxels, geometry);
  if (!orientation) {
    return fail(orientation.error().status, path.string() + ": " + orientation.error().message);
  }
  volume.notes = std::move(orientation->notes);
  const uint64_t step_bytes = volume_bytes(voxels, stored_bytes(header.type));
  const uint64_t steps = header.sizes.size() > 3 ? static_cast<uint64_t>(header.sizes[3]) : 1;
  if (itk_bytes(header) != step_bytes * steps) {
    return fail(Status::malformed_volume,
                path.string() + ": the header's sizes are not possible: export the volume again");
  }

  const auto file = size_of_file(path);
  if (!file) return tl::unexpected(file.error());
  // No coding that ITK reads whole comes near this: text needs two bytes a voxel, JPEG-LS and
  // deflate stay below 1 : 1100.
  if (data_files.empty() && step_bytes / 4096 > *file / steps + 1) {
    return fail(Status::truncated,
                fmt::format("{}: the header promises {} bytes of voxels, the file has {} bytes: "
                            "the file is incomplete, or its header is wrong; copy or download it "
                            "again",
                            path.string(), step_bytes, *file));
  }
  volume.notes.push_back(
      fmt::format("this file can only be read whole, which takes {} MB of memory",
                  step_bytes * steps / 1000000));
  VolumeHeader volume_header{orientation->grid, header.type, std::move(format), volume_name(path)};
  volume.source = std::make_unique<WholeSource>(
      itk_format, header, std::move(volume_header), orientation->reverse_rows, path.string(),
      step_bytes * steps, step_bytes * *step, std::move(data_files), options.memory_bytes);
  return volume;
}

}  // namespace isosplat
