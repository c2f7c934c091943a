#include "shared/import/dicom/source.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shared/import/dicom/pixels.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/slice_range.h"

namespace isosplat::import::dicom {
namespace {

/// out = (1 − weight) · out + weight · other, rounded for integers.
template <class T>
void blend(std::span<std::byte> out, std::span<const std::byte> other, double weight) {
  for (size_t at = 0; at + sizeof(T) <= out.size(); at += sizeof(T)) {
    T a, b;
    std::memcpy(&a, out.data() + at, sizeof(T));
    std::memcpy(&b, other.data() + at, sizeof(T));
    const double mixed = (1 - weight) * static_cast<double>(a) + weight * static_cast<double>(b);
    const T value = static_cast<T>(std::is_integral_v<T> ? std::round(mixed) : mixed);
    std::memcpy(out.data() + at, &value, sizeof(T));
  }
}

void blend(VoxelType type, std::span<std::byte> out, std::span<const std::byte> other,
           double weight) {
  with_voxel_type(type, [&]<class T>(T) { blend<T>(out, other, weight); });
}

/// A slice of the volume, from the pixels of one or two frames.
struct SlicePixels {
  FramePixels first, second;
  double weight = 0;
  std::optional<double> background;  ///< the value of all voxels, instead of frames
};

void fill(VoxelType type, std::span<std::byte> out, double value) {
  with_voxel_type(type, [&]<class T>(T) {
    const T voxel = static_cast<T>(value);
    for (size_t at = 0; at + sizeof(T) <= out.size(); at += sizeof(T)) {
      std::memcpy(out.data() + at, &voxel, sizeof(T));
    }
  });
}

class DicomSource : public VolumeSource {
 public:
  /// `images`: the images that `slices` refer to.
  DicomSource(VolumeHeader header, std::vector<Image> images, std::vector<SlicePixels> slices,
              bool reverse, bool fill_missing, uint64_t memory_bytes)
      : header_(std::move(header)),
        images_(std::move(images)),
        slices_(std::move(slices)),
        reverse_(reverse),
        fill_missing_(fill_missing),
        memory_bytes_(memory_bytes) {}

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const Index3 n = header_.grid.voxels;
    const size_t row = static_cast<size_t>(n.x) * voxel_bytes(header_.type);
    const size_t bytes = row * static_cast<size_t>(n.y);
    if (auto inside = check_slices(header_, first, count, out.size()); !inside) return inside;
    // One child process decodes a batch of compressed slices, of a few MB.
    const auto batch = static_cast<size_t>(std::clamp<size_t>((size_t{16} << 20) / bytes, 1, 64));
    const auto slices =
        std::span(slices_).subspan(static_cast<size_t>(first), static_cast<size_t>(count));
    for (size_t i = 0, some = 0; i < slices.size(); i += some) {
      // Background slices end a batch, and are not decoded.
      const auto is_background = [&](size_t k) { return slices[k].background.has_value(); };
      for (some = 1; some < batch && i + some < slices.size(); ++some) {
        if (is_background(i) || is_background(i + some)) break;
      }
      const auto to = out.subspan(i * bytes, some * bytes);
      if (is_background(i)) {
        fill(header_.type, to, *slices[i].background);
        continue;
      }
      if (auto r = read_batch(slices.subspan(i, some), to); !r) return r;
      for (size_t k = 0; reverse_ && k < some; ++k) reverse_rows(to.subspan(k * bytes, bytes), row);
    }
    return {};
  }

  uint64_t resident_bytes() const override { return 0; }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files;
    for (const Image& image : images_) files.emplace_back(image.file);
    return files;
  }

 private:
  Result<void> read_batch(std::span<const SlicePixels> slices, std::span<std::byte> out) {
    std::vector<FramePixels> frames;
    for (const SlicePixels& slice : slices) frames.push_back(slice.first);
    auto read = read_frames(frames, header_.type, fill_missing_, memory_bytes_, out);
    if (!read) return read;
    const size_t bytes = out.size() / slices.size();
    for (size_t i = 0; i < slices.size(); ++i) {
      if (slices[i].weight == 0) continue;
      other_.resize(bytes);
      read =
          read_frames({&slices[i].second, 1}, header_.type, fill_missing_, memory_bytes_, other_);
      if (!read) return read;
      blend(header_.type, out.subspan(i * bytes, bytes), other_, slices[i].weight);
    }
    return {};
  }

  VolumeHeader header_;
  std::vector<Image> images_;
  std::vector<SlicePixels> slices_;
  bool reverse_, fill_missing_;
  uint64_t memory_bytes_;
  std::vector<std::byte> other_;
};

}  // namespace

std::unique_ptr<VolumeSource> make_dicom_source(VolumeHeader header, const Collection& collection,
                                                std::span<const Plane> planes, const Values& values,
                                                bool reverse_rows, const ImportOptions& options) {
  // Keeps only the images that the volume uses.
  std::vector<uint32_t> new_index(collection.images.size(), ~uint32_t{0});
  std::vector<Image> images;
  const auto keep_image_of = [&](uint32_t frame) {
    uint32_t& at = new_index[collection.frames[frame].image];
    if (at != ~uint32_t{0}) return;
    at = static_cast<uint32_t>(images.size());
    images.push_back(collection.images[collection.frames[frame].image]);
  };
  for (const Plane& plane : planes) {
    keep_image_of(plane.first);
    if (plane.weight > 0) keep_image_of(plane.second);
  }
  const auto pixels_of = [&](uint32_t index) {
    const Frame& frame = collection.frames[index];
    const bool is_stored = values.slope != 1 || values.intercept != 0;
    return FramePixels{
        &images[new_index[frame.image]], frame.index, frame.tile, is_stored ? 1 : frame.slope,
        is_stored ? 0 : frame.intercept, values.label};
  };
  std::vector<SlicePixels> slices;
  for (const Plane& plane : planes) {
    const uint32_t second =
        plane.weight > 0 ? plane.second : plane.first;  // otherwise it is not read
    slices.push_back({pixels_of(plane.first), pixels_of(second), plane.weight, {}});
    if (plane.is_background) {
      const Segmentation& segmentation = slices.back().first.image->segmentation;
      slices.back().background =
          values.label ? *values.label == segmentation.background : segmentation.background;
    }
  }
  return std::make_unique<DicomSource>(std::move(header), std::move(images), std::move(slices),
                                       reverse_rows, options.allowed.has(Allowance::truncated),
                                       options.memory_bytes);
}

}  // namespace isosplat::import::dicom
