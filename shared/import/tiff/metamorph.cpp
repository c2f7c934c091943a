#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/tiff/series.h"

// Reads MetaMorph's stacks (.stk): one directory, followed by the voxels of all planes. Four tags
// have tables (Universal Imaging Corporation, "MetaMorph Stack (STK) Image File Format"):
//
//   UIC1 (33628)  n times u32 id, u32 value or offset of it
//   UIC2 (33629)  for each plane u32 numerator, u32 denominator of the distance from the plane
//                 before, and four u32 of dates and times
//   UIC3 (33630)  for each plane u32 numerator, u32 denominator of the wavelength
//   UIC4 (33631)  u16 id and a value for each plane, until the id is 0
//
// The count of UIC2, UIC3 and UIC4 is that of planes.
namespace isosplat::import {
namespace {

constexpr uint64_t kMaxPlanes = uint64_t{1} << 24;

class Metamorph {
 public:
  explicit Metamorph(TiffDirectoryReader& reader) : reader_(reader) {}

  std::optional<uint32_t> u32(uint64_t at) {
    std::byte raw[4];
    if (!reader_.file().read(at, raw)) return std::nullopt;
    uint32_t value = 0;
    for (int i = 3; i >= 0; --i) value = value << 8 | std::to_integer<uint32_t>(raw[i]);
    return value;
  }

  std::optional<double> ratio(uint64_t at) {
    const auto above = u32(at), below = u32(at + 4);
    if (!above || !below || *below == 0) return std::nullopt;
    return static_cast<double>(*above) / static_cast<double>(*below);
  }

  /// A text behind its length.
  std::string text(uint64_t at) {
    const auto length = u32(at);
    if (!length || *length > 1024) return {};
    std::string found(*length, '\0');
    if (!reader_.file().read(at + 4, std::as_writable_bytes(std::span(found)))) return {};
    return found.c_str();
  }

  /// The ratios at the beginning of the records of a table.
  std::vector<double> ratios(const TiffEntry& entry, uint64_t record) {
    std::vector<double> all;
    for (uint64_t i = 0; i < entry.count; ++i) {
      const auto value = ratio(entry.at + i * record);
      if (!value) return {};
      all.push_back(*value);
    }
    return all;
  }

  /// The size of pixels, if the spatial calibration is switched on.
  void read_calibration(const TiffEntry& uic1, TiffSeries& series) {
    if (uic1.type != 4) return;
    bool is_on = true;
    for (uint64_t i = 0; i < std::min<uint64_t>(uic1.count, 1000); ++i) {
      const auto id = u32(uic1.at + 8 * i), value = u32(uic1.at + 8 * i + 4);
      if (!id || !value) return;
      if (*id == 3) is_on = *value != 0;
      if (*id == 4 && *value >= 8) series.lengths[0] = ratio(*value);
      if (*id == 5 && *value >= 8) series.lengths[1] = ratio(*value);
      if (*id == 6 && *value >= 8) series.units.fill(text(*value));
    }
    if (!is_on || series.lengths[0].value_or(0) <= 0) series.lengths[0] = std::nullopt;
    if (!is_on || series.lengths[1].value_or(0) <= 0) series.lengths[1] = std::nullopt;
  }

  /// The position of each plane along the optical axis, if UIC4 has it.
  std::vector<double> absolute_z(const TiffEntry& uic4, uint64_t planes) {
    uint64_t at = uic4.at;
    for (int i = 0; i < 100; ++i) {
      std::byte raw[2];
      if (!reader_.file().read(at, raw)) return {};
      const unsigned id = std::to_integer<unsigned>(raw[0]) | std::to_integer<unsigned>(raw[1])
                                                                  << 8;
      at += 2;
      if (id == 40) return ratios({0, 4, planes, at}, 8);
      if (id == 28 || id == 29) {
        at += 16 * planes;  // two ratios for each plane
      } else if (id == 41) {
        at += 4 * planes;
      } else if (id == 37) {
        for (uint64_t plane = 0; plane < planes; ++plane) {
          const auto length = u32(at);
          if (!length || *length > 1024) return {};
          at += 4 + *length;
        }
      } else {
        return {};  // 0: the end
      }
    }
    return {};
  }

 private:
  TiffDirectoryReader& reader_;
};

bool all_same(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [&](double v) { return v == values.front(); });
}

/// The distance between planes by their positions; nothing if all positions are equal. Adds a note
/// if the distance varies.
std::optional<double> step_of(const std::vector<double>& steps, std::vector<std::string>& notes) {
  double low = 1e300, high = 0, sum = 0;
  for (const double step : steps) {
    low = std::min(low, std::abs(step)), high = std::max(high, std::abs(step));
    sum += std::abs(step);
  }
  if (steps.empty() || !(low > 0) || !std::isfinite(sum)) return std::nullopt;
  const double mean = sum / static_cast<double>(steps.size());
  if (high - low > 0.01 * mean) {
    notes.push_back(
        fmt::format("the distances between planes vary from {} to {}: their mean is "
                    "taken for all",
                    low, high));
  }
  return mean;
}

}  // namespace

TiffSeriesList metamorph_series(const std::filesystem::path& path, const TiffPages& pages,
                                const TiffPage& first) {
  auto reader = TiffDirectoryReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  TiffSeries series;
  uint64_t planes = 1;
  for (const auto& entry : {pages.uic2, pages.uic3, pages.uic4}) {
    if (entry) planes = std::max(planes, entry->count);
  }
  if (planes > kMaxPlanes || pages.big_endian) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected a MetaMorph stack of up to {} planes, little-endian, "
                            "found {}: save it again",
                            path.string(), kMaxPlanes, planes));
  }
  static_cast<void>(first);
  Metamorph tables(*reader);
  const auto distances = pages.uic2 ? tables.ratios(*pages.uic2, 24) : std::vector<double>{};
  const auto wavelengths = pages.uic3 ? tables.ratios(*pages.uic3, 8) : std::vector<double>{};
  if (pages.uic1) tables.read_calibration(*pages.uic1, series);

  // In some files the distance of the first plane has no meaning, in others that of the last plane.
  std::vector<double> steps = distances;
  if (steps.size() > 2 && steps.front() == 0) steps.erase(steps.begin());
  if (steps.size() > 2 && steps.back() == 0) steps.pop_back();
  auto step = step_of(steps, series.notes);
  if (!step && pages.uic4) {
    const auto heights = tables.absolute_z(*pages.uic4, planes);
    std::vector<double> between;
    for (size_t i = 1; i < heights.size(); ++i) between.push_back(heights[i] - heights[i - 1]);
    step = step_of(between, series.notes);
  }
  const bool have_colours = !wavelengths.empty() && !all_same(wavelengths);
  const TiffAxis axis = have_colours ? TiffAxis::channel : step ? TiffAxis::z : TiffAxis::time;
  series.size(axis) = planes;
  series.lengths[2] = axis == TiffAxis::z ? step : std::nullopt;
  series.pages = planes;
  series.counted = true;
  series.follow = pages.offsets.size() == 1 && planes > 1;
  return std::vector{std::move(series)};
}

}  // namespace isosplat::import
