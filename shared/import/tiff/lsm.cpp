#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "shared/import/tiff/series.h"

// Reads Zeiss LSM: pages of x and y whose samples are the channels, each followed by a small copy.
// Tag 34412 has the sizes (Carl Zeiss, "LSM File Format"; little-endian):
//
//   0 u32 magic          12 i32 y          24 i32 times      40 f64 x, y, z of a voxel in metres
//   4 i32 bytes          16 i32 z          28 i32 type       88 u16 kind of scan
//   8 i32 x              20 i32 channels   32 thumbnail     264 i32 positions, 268 i32 tiles
namespace isosplat::import {
namespace {

class Fields {
 public:
  explicit Fields(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  T at(size_t offset) const {
    T value{};
    if (offset + sizeof value <= bytes_.size()) {
      std::memcpy(&value, bytes_.data() + offset, sizeof value);
    }
    return value;
  }

  uint64_t count(size_t offset) const {
    const int32_t value = at<int32_t>(offset);
    return value > 0 ? static_cast<uint64_t>(value) : 0;
  }

 private:
  std::span<const std::byte> bytes_;
};

/// The lengths of a voxel at `offset`, if they can be those of a microscope.
bool read_lengths(const Fields& fields, size_t offset, TiffSeries& series) {
  const auto plausible = [](double metres) { return metres > 1e-12 && metres < 1; };
  for (size_t axis = 0; axis < 3; ++axis) {
    const double metres = fields.at<double>(offset + 8 * axis);
    series.lengths[axis] = plausible(metres) ? std::optional(metres) : std::nullopt;
  }
  series.units.fill(std::string(1, 'm'));
  return series.lengths[0].has_value();
}

}  // namespace

TiffSeriesList lsm_series(const std::filesystem::path& path, const TiffPages& pages,
                          const TiffPage& first) {
  auto reader = TiffDirectoryReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  std::vector<std::byte> raw(static_cast<size_t>(std::min<uint64_t>(pages.lsm->count, 500)));
  if (raw.size() < 90 || pages.big_endian || !reader->file().read(pages.lsm->at, raw)) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected the sizes of an LSM file in its tag 34412, found {} "
                            "bytes: copy or download it again",
                            path.string(), raw.size()));
  }
  const Fields fields(raw);
  TiffSeries series;
  const uint64_t z = fields.count(16), channels = fields.count(20), times = fields.count(24);
  const uint64_t volumes =
      std::max<uint64_t>(fields.count(264), 1) * std::max<uint64_t>(fields.count(268), 1);
  const uint64_t most = uint64_t{1} << 24;
  if (z < 1 || channels < 1 || times < 1 || z > most || times > most / z ||
      volumes > most / z / times) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected sizes of an LSM file, found {} slices, {} channels, {} "
                            "times and {} positions: copy or download it again",
                            path.string(), z, channels, times, volumes));
  }
  series.sizes = {z, channels, times};
  if (channels > 1 && channels == static_cast<uint64_t>(first.samples)) {
    series.in_samples = TiffAxis::channel;
  }
  // Time series of planes have the times first, all others the slices.
  const auto scan = fields.at<uint16_t>(88);
  const bool times_first = scan == 3 || scan == 9;
  series.order = times_first ? std::array{TiffAxis::channel, TiffAxis::time, TiffAxis::z}
                             : std::array{TiffAxis::channel, TiffAxis::z, TiffAxis::time};
  series.width = static_cast<int64_t>(fields.count(8));
  series.height = static_cast<int64_t>(fields.count(12));
  series.counted = true;
  series.pages = z * times * (series.in_samples ? 1 : channels);
  if (!read_lengths(fields, 40, series) && read_lengths(fields, 44, series)) {
    series.notes.push_back(
        "the size of voxels is four bytes after its place in the LSM file's table");
  }
  std::vector<TiffSeries> all;
  for (uint64_t i = 0; i < volumes; ++i) {
    series.first_page = i * series.pages;
    if (volumes > 1) series.name = fmt::format("position {}", i);
    all.push_back(series);
    if (all.size() > 10000) break;
  }
  return all;
}

}  // namespace isosplat::import
