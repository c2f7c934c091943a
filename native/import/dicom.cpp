#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "native/import/array_source.h"
#include "native/import/formats.h"
#include "native/import/slice_files.h"

// DICOM: a folder with a file per slice, or one file with several frames. ITK (GDCM) finds the
// series, decodes the slices and applies the rescaling to physical values (Hounsfield units, say);
// which slice lies where is computed here from their positions.
namespace isosplat {
namespace {

struct Slice {
  std::string file;
  ItkHeader header;
  double along = 0;  ///< position along the normal of the slices
};

bool same_size(const ItkHeader& a, const ItkHeader& b) {
  return a.sizes.size() >= 2 && b.sizes.size() >= 2 && a.sizes[0] == b.sizes[0] &&
         a.sizes[1] == b.sizes[1];
}

Vec3d column(const std::array<double, 9>& m, size_t index) {
  return {m[index], m[3 + index], m[6 + index]};
}

/// One type that holds the values of all slices: rescaling can differ from slice to slice.
VoxelType common_type(const std::vector<Slice>& slices) {
  const VoxelType first = read_type({slices[0].header.type, false, 1, 0});
  bool same = true, integers = true;
  for (const Slice& slice : slices) {
    const VoxelType type = read_type({slice.header.type, false, 1, 0});
    same = same && type == first;
    integers =
        integers && type != VoxelType::f32 && type != VoxelType::f64 && type != VoxelType::u32;
  }
  return same ? first : integers ? VoxelType::i32 : VoxelType::f64;
}

class DicomSource : public VolumeSource {
 public:
  DicomSource(VolumeHeader header, std::vector<Slice> slices, bool reverse)
      : header_(std::move(header)), slices_(std::move(slices)), reverse_(reverse) {}

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const Index3 n = header_.grid.voxels;
    const size_t pixels = static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
    const size_t bytes = pixels * voxel_bytes(header_.type);
    if (first < 0 || count < 1 || int64_t{first} + count > n.z ||
        out.size() != bytes * static_cast<size_t>(count)) {
      return fail(Status::invalid_argument, "slices outside the volume were asked for");
    }
    // A batch of slices is decoded by one child process; a batch is what a few MB hold.
    const auto batch = static_cast<int32_t>(std::clamp<size_t>((size_t{16} << 20) / bytes, 1, 64));
    for (int32_t i = 0; i < count; i += batch) {
      const int32_t some = std::min(batch, count - i);
      auto read = read_batch(
          std::span(slices_).subspan(static_cast<size_t>(first + i), static_cast<size_t>(some)),
          out.subspan(static_cast<size_t>(i) * bytes, static_cast<size_t>(some) * bytes));
      if (!read) return read;
    }
    return {};
  }

  uint64_t resident_bytes() const override { return 0; }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files;
    for (const Slice& slice : slices_) files.emplace_back(slice.file);
    return files;
  }

 private:
  Result<void> read_batch(std::span<const Slice> slices, std::span<std::byte> out) {
    std::vector<std::string> files;
    std::vector<ItkHeader> headers;
    uint64_t bytes = 0;
    for (const Slice& slice : slices) {
      files.push_back(slice.file);
      headers.push_back(slice.header);
      bytes += itk_bytes(slice.header);
    }
    scratch_.resize(static_cast<size_t>(bytes));
    auto read = read_itk_voxels(ItkFormat::dicom, files, headers, scratch_);
    if (!read) return read;
    const size_t slice_bytes = out.size() / slices.size();
    const size_t row = static_cast<size_t>(header_.grid.voxels.x) * voxel_bytes(header_.type);
    size_t at = 0;
    for (size_t i = 0; i < slices.size(); ++i) {
      const auto stored = std::span(scratch_).subspan(at, itk_bytes(headers[i]));
      at += stored.size();
      const auto to = out.subspan(i * slice_bytes, slice_bytes);
      decode({headers[i].type, false, 1, 0}, stored, header_.type, to);
      if (reverse_) reverse_rows(to, row);
    }
    return {};
  }

  VolumeHeader header_;
  std::vector<Slice> slices_;
  bool reverse_;
  std::vector<std::byte> scratch_;
};

Result<std::vector<Slice>> read_slice_headers(const std::vector<std::string>& files) {
  const auto headers = read_itk_headers(ItkFormat::dicom, files);
  if (!headers) return tl::unexpected(headers.error());
  std::vector<Slice> slices;
  for (size_t i = 0; i < files.size(); ++i) {
    const ItkHeader& info = (*headers)[i];
    if (info.components != 1) return not_scalar(files[i], info.components);
    if (!info.has_known_type) return unknown_type(files[i], "unknown");
    const auto& sizes = info.sizes;
    if (sizes.size() < 2 || (sizes.size() > 2 && sizes[2] != 1) ||
        !same_size(info, headers->front())) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected a single slice of the same size as {}, found another "
                              "size or several frames: take the odd file out of the folder",
                              files[i], files[0]));
    }
    slices.push_back({files[i], info, 0});
  }
  return slices;
}

/// Orders slices along their normal, and takes one time step of them. Returns what a person should
/// know.
Result<std::vector<std::string>> arrange(const std::filesystem::path& path,
                                         std::vector<Slice>& slices, const ImportOptions& options) {
  std::vector<std::string> notes;
  const auto& direction = slices[0].header.geometry.direction;
  const Vec3d normal = cross(column(direction, 0), column(direction, 1));
  for (Slice& slice : slices) slice.along = dot(slice.header.geometry.origin, normal);
  std::sort(slices.begin(), slices.end(),
            [](const Slice& a, const Slice& b) { return natural_order(a.file, b.file); });
  const auto [nearest, farthest] =
      std::minmax_element(slices.begin(), slices.end(),
                          [](const Slice& a, const Slice& b) { return a.along < b.along; });
  const double extent = farthest->along - nearest->along;
  const double tolerance = 1e-3 * extent / static_cast<double>(slices.size());
  if (!(extent > 1e-6)) {
    notes.push_back(
        "the slices do not say where they are: they are taken in the order of their "
        "names");
    if (options.time_step.value_or(0) != 0) {
      return fail(
          Status::invalid_argument,
          fmt::format("{}: the series has no time steps: leave --time-step away", path.string()));
    }
    return notes;
  }
  std::stable_sort(slices.begin(), slices.end(),
                   [](const Slice& a, const Slice& b) { return a.along < b.along; });

  const std::vector<int64_t> sizes = slices[0].header.sizes;

  // Slices at the same place are time steps (or echoes, …), in the order of their names.
  std::vector<std::vector<Slice>> places;
  for (Slice& slice : slices) {
    if (places.empty() || slice.along - places.back()[0].along > tolerance) places.emplace_back();
    places.back().push_back(std::move(slice));
  }
  size_t steps = places[0].size();
  bool even = true;
  for (const auto& place : places) {
    even = even && place.size() == steps;
    steps = std::min(steps, place.size());
  }
  if (!even) {
    notes.push_back("some slices lie at the same place as others: the first of each are taken");
    steps = 1;
  }
  const auto step = choose_time_step(
      path, {sizes[0], sizes[1], static_cast<int64_t>(places.size()), static_cast<int64_t>(steps)},
      options);
  if (!step) return tl::unexpected(step.error());
  slices.clear();
  for (auto& place : places) slices.push_back(std::move(place[static_cast<size_t>(*step)]));

  double least = extent, most = 0;
  for (size_t i = 1; i < slices.size(); ++i) {
    const double gap = slices[i].along - slices[i - 1].along;
    least = std::min(least, gap);
    most = std::max(most, gap);
  }
  if (most > 1.2 * least) {
    notes.push_back(
        fmt::format("slices are missing or unevenly spaced: the gaps between them are "
                    "{:.3g} to {:.3g} mm; their mean is taken",
                    least, most));
  }
  return notes;
}

}  // namespace

Result<OpenVolume> open_dicom_file(const std::filesystem::path& path,
                                   const ImportOptions& options) {
  const auto header = read_itk_header(ItkFormat::dicom, path);
  if (!header) return tl::unexpected(header.error());
  const auto& sizes = header->sizes;
  if (sizes.size() < 3 || sizes[2] < 2) {
    return fail(Status::no_cells,
                fmt::format("{}: expected a volume, found a single DICOM slice: give the folder "
                            "that holds the series",
                            path.string()));
  }
  return open_whole(ItkFormat::dicom, *header, "DICOM", path, options);
}

Result<OpenVolume> open_dicom_folder(const std::filesystem::path& path,
                                     const ImportOptions& options) {
  auto series = list_dicom_series(path);
  if (!series) return tl::unexpected(series.error());
  if (series->empty()) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected a folder with a DICOM series or TIFF slices, found "
                            "neither: give the folder that holds the slices themselves",
                            path.string()));
  }
  OpenVolume volume;
  const auto& files = (*series)[0].files;
  if (series->size() > 1) {
    volume.notes.push_back(fmt::format(
        "the folder holds {} DICOM series: the largest, {} with {} files, is taken; for another, "
        "put its files into a folder of their own",
        series->size(), (*series)[0].id, files.size()));
  }
  if (files.size() == 1) {
    auto single = open_dicom_file(files[0], options);
    if (single) {
      single->notes.insert(single->notes.begin(), volume.notes.begin(), volume.notes.end());
    }
    return single;
  }
  auto slices = read_slice_headers(files);
  if (!slices) return tl::unexpected(slices.error());
  auto notes = arrange(path, *slices, options);
  if (!notes) return tl::unexpected(notes.error());
  volume.notes.insert(volume.notes.end(), notes->begin(), notes->end());

  // The third axis runs from the first slice to the last.
  HeaderGeometry geometry = slices->front().header.geometry;
  const auto count = static_cast<int64_t>(slices->size());
  const Vec3d path_through =
      slices->back().header.geometry.origin - slices->front().header.geometry.origin;
  const double distance = length(path_through);
  if (count > 1 && distance > 1e-6) {
    geometry.spacing.z = distance / static_cast<double>(count - 1);
    geometry.direction[2] = path_through.x / distance;
    geometry.direction[5] = path_through.y / distance;
    geometry.direction[8] = path_through.z / distance;
  }
  if (options.spacing) geometry.spacing = *options.spacing;
  auto orientation =
      orient({slices->front().header.sizes[0], slices->front().header.sizes[1], count}, geometry);
  if (!orientation) {
    return fail(orientation.error().status, path.string() + ": " + orientation.error().message);
  }
  for (std::string& note : orientation->notes) volume.notes.push_back(std::move(note));
  VolumeHeader header{orientation->grid, common_type(*slices), "DICOM", volume_name(path)};
  volume.source = std::make_unique<DicomSource>(std::move(header), std::move(*slices),
                                                orientation->reverse_rows);
  return volume;
}

}  // namespace isosplat
