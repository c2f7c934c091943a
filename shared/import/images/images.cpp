#include "shared/import/images/images.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/geometry/orientation.h"
#include "shared/import/images/file.h"
#include "shared/import/slices/slice_files.h"
#include "shared/import/slices/slice_order.h"
#include "shared/import/text/commands.h"
#include "shared/import/volume/volume_name.h"
#include "shared/import/voxels/absent_voxels.h"
#include "shared/import/voxels/slice_range.h"

namespace isosplat::import {
namespace {

class ImageSource : public VolumeSource {
 public:
  ImageSource(VolumeHeader header, ImageInfo info, std::vector<std::filesystem::path> slices,
              uint64_t memory_bytes)
      : header_(std::move(header)),
        info_(info),
        slices_(std::move(slices)),
        memory_bytes_(memory_bytes) {
    const bool lacks_some =
        std::any_of(slices_.begin(), slices_.end(), [](const auto& each) { return each.empty(); });
    if (lacks_some) header_.type = type_with_absent(header_.type);
  }

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const size_t pixels = static_cast<size_t>(info_.width) * static_cast<size_t>(info_.height);
    const size_t slice = pixels * voxel_bytes(header_.type);
    if (auto inside = check_slices(header_, first, count, out.size()); !inside) return inside;
    for (int32_t i = 0; i < count; ++i) {
      const auto to = out.subspan(static_cast<size_t>(i) * slice, slice);
      const auto& path = slices_[static_cast<size_t>(first + i)];
      if (path.empty()) {
        make_absent(header_.type, to);
        continue;
      }
      const auto info = read_image_info(path);
      if (!info) return tl::unexpected(info.error());
      std::span<std::byte> stored = to;
      if (header_.type != info_.type()) {
        stored_.resize(pixels * voxel_bytes(info_.type()));
        stored = stored_;
      }
      if (!info->same_kind(info_)) {
        return fail(Status::io_error, path.string() + ": the picture changed while it was read");
      }
      if (auto read = decode_image(path, *info, memory_bytes_, stored); !read) return read;
      if (header_.type != info_.type()) convert_voxels(info_.type(), stored, header_.type, to);
    }
    return {};
  }

  uint64_t resident_bytes() const override {
    return 3 * static_cast<uint64_t>(info_.width) * static_cast<uint64_t>(info_.height) *
           voxel_bytes(info_.type());
  }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files;
    std::copy_if(slices_.begin(), slices_.end(), std::back_inserter(files),
                 [](const auto& slice) { return !slice.empty(); });
    return files;
  }

 private:
  VolumeHeader header_;
  ImageInfo info_;
  std::vector<std::filesystem::path> slices_;
  uint64_t memory_bytes_;
  std::vector<std::byte> stored_;  ///< a slice as stored, if other slices are absent
};

constexpr std::string_view kExtensions[][3] = {
    {".png", ".png", ".png"}, {".jpg", ".jpeg", ".jpe"}, {".jp2", ".j2k", ".jpx"}};

/// The pictures of a folder, in the format with the most bytes.
std::vector<std::filesystem::path> images_of(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> most;
  for (const auto& extensions : kExtensions) {
    auto files = files_of_folder(folder, {std::begin(extensions), std::end(extensions)});
    if (total_bytes(files) > total_bytes(most)) most = std::move(files);
  }
  return most;
}

/// Checks that a picture has grey samples that fit a voxel.
Result<void> check_grey(const std::filesystem::path& folder, const std::filesystem::path& file,
                        const ImageInfo& info) {
  if (info.channels > 1) {
    const std::string grey = shell_word(folder.filename().string() + "_grey");
    return fail(
        Status::unsupported_type,
        fmt::format("{}: expected grey pictures, found {} channels (colours or transparency): make "
                    "a folder of grey ones with mkdir {} && mogrify -path {} -alpha off "
                    "-colorspace Gray {}/*{}",
                    file.string(), info.channels, grey, grey, shell_word(folder),
                    file.extension().string()));
  }
  if (info.bits > 16 || (info.format == "JPEG" && info.bits != 8)) {
    return fail(Status::unsupported_type,
                fmt::format("{}: expected samples of at most {} bits, found {}: save the slices as "
                            "TIFF",
                            file.string(), info.format == "JPEG" ? 8 : 16, info.bits));
  }
  return {};
}

}  // namespace

uint64_t image_bytes_of_folder(const std::filesystem::path& folder) {
  const auto images = images_of(folder);
  return images.size() > 1 ? total_bytes(images) : 0;
}

Result<OpenVolume> open_image_folder(const std::filesystem::path& path,
                                     const ImportOptions& options) {
  if (options.time_step.value_or(0) != 0) {
    return fail(Status::invalid_argument,
                fmt::format("{}: a folder of pictures has no time steps: remove --time-step",
                            path.string()));
  }
  auto order = order_slices(path, images_of(path), options.allowed);
  if (!order) return tl::unexpected(order.error());
  std::vector<std::string> notes = std::move(order->notes);
  std::optional<ImageInfo> first;
  for (const auto& file : order->slices) {
    if (file.empty()) continue;
    const auto info = read_image_info(file);
    if (!info) return tl::unexpected(info.error());
    if (auto grey = check_grey(path, file, *info); !grey) return tl::unexpected(grey.error());
    if (!first) first = *info;
    if (info->same_kind(*first)) continue;
    return fail(
        Status::malformed_volume,
        fmt::format("{}: expected a slice of {} × {} pixels of {} bits like the first, found "
                    "{} × {} of {} bits: remove the file, or save all with one size and type",
                    file.string(), first->width, first->height, first->bits, info->width,
                    info->height, info->bits));
  }
  if (!first) return damaged_image(path);
  HeaderGeometry geometry;
  if (options.spacing) {
    geometry.spacing = *options.spacing;
  } else if (first->density_x && first->density_y) {
    notes.push_back(fmt::format(
        "the pictures state {:.6g} × {:.6g} pixels per metre, which is usually the resolution of a "
        "screen or printer, and not the distance of slices: spacing 1,1,1 is assumed; --spacing "
        "sets another",
        *first->density_x, *first->density_y));
  } else {
    notes.push_back(
        "the pictures state no distance between voxels: spacing 1,1,1 is assumed; --spacing sets "
        "another");
  }
  if (first->format == "JPEG") {
    notes.push_back("JPEG does not keep samples exactly: values differ a little from the original");
  }
  const auto slices = static_cast<int64_t>(order->slices.size());
  auto oriented = orient({first->width, first->height, slices}, geometry);
  if (!oriented) {
    return fail(oriented.error().status, path.string() + ": " + oriented.error().message);
  }
  notes.insert(notes.end(), oriented->notes.begin(), oriented->notes.end());
  VolumeHeader header{oriented->grid, first->type(), std::string(first->format), volume_name(path)};
  return OpenVolume{std::make_unique<ImageSource>(std::move(header), *first,
                                                  std::move(order->slices), options.memory_bytes),
                    std::move(notes)};
}

}  // namespace isosplat::import
