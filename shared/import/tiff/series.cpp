#include "shared/import/tiff/series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/text/header_text.h"
#include "shared/import/text/xml_scanner.h"

namespace isosplat::import {
namespace {

/// Without a description: each run of pages of one size and type is a series.
std::vector<TiffSeries> undescribed_series(const TiffPages& pages) {
  std::vector<TiffSeries> all;
  const TiffPageKind* last = nullptr;
  for (size_t page = 0; page < pages.entries.size(); ++page) {
    const TiffPageKind& kind = pages.entries[page].kind;
    if (!last || !(kind == *last)) {
      TiffSeries series;
      series.first_page = page;
      if (kind.samples > 1) series.in_samples = TiffAxis::channel;
      series.size(TiffAxis::channel) = std::max<uint64_t>(kind.samples, 1);
      series.depth_is_z = kind.depth > 1;
      all.push_back(std::move(series));
    }
    last = &kind;
    ++all.back().pages;
  }
  for (TiffSeries& series : all) {
    const uint64_t depth = pages.entries[static_cast<size_t>(series.first_page)].kind.depth;
    if (series.depth_is_z) {
      series.size(TiffAxis::z) = depth;
      series.size(TiffAxis::time) = series.pages;
      series.unnamed = series.pages > 1;
    } else {
      series.size(TiffAxis::z) = series.pages;
    }
  }
  return all;
}

/// GDAL's scale and offset of the first sample: value = offset + scale · voxel.
void read_gdal_scale(std::string_view xml, TiffSeries& series) {
  XmlScanner scanner(xml);
  while (const auto tag = scanner.next()) {
    if (tag->name != "Item" || !tag->begins || tag->attribute("sample").value_or("0") != "0")
      continue;
    const std::string role = tag->attribute("role").value_or("");
    const auto number = number_in(scanner.content());
    if (!number || !std::isfinite(*number)) continue;
    if (role == "scale" && *number != 0) series.slope = *number;
    if (role == "offset") series.intercept = *number;
  }
}

/// The series, according to the kind of the file.
TiffSeriesList described_series(const std::filesystem::path& path, const TiffPages& pages,
                                const TiffPage& first) {
  const std::string& text = first.description;
  if (pages.lsm) return lsm_series(path, pages, first);
  if (pages.uic2 || pages.uic3 || pages.uic4) return metamorph_series(path, pages, first);
  if (is_ome(text)) return ome_series(path, text);
  if (is_imagej(text)) return imagej_series(path, pages, first);
  if (is_shaped(text)) return shaped_series(path, pages, first);
  auto all = undescribed_series(pages);
  if (!pages.gdal_metadata.empty()) read_gdal_scale(pages.gdal_metadata, all[0]);
  return all;
}

}  // namespace

uint64_t plane_number(const TiffSeries& series, uint64_t z, uint64_t channel, uint64_t time) {
  const uint64_t index[] = {z, channel, time};
  uint64_t number = 0, step = 1;
  for (const TiffAxis axis : series.order) {
    if (axis == series.in_samples || (axis == TiffAxis::z && series.depth_is_z)) continue;
    number += index[static_cast<size_t>(axis)] * step;
    step *= series.size(axis);
  }
  return number;
}

Result<std::vector<TiffSeries>> tiff_series(const std::filesystem::path& path,
                                            const TiffPages& pages, const TiffPage& first) {
  auto all = described_series(path, pages, first);
  if (!all) return all;
  // Descriptions do not mention several samples per pixel, such as those of colours.
  for (TiffSeries& series : *all) {
    const auto page = static_cast<size_t>(series.first_page);
    const uint64_t samples = series.ome.empty() && page < pages.entries.size()
                                 ? pages.entries[page].kind.samples
                                 : static_cast<uint64_t>(first.samples);
    if (samples < 2 || series.in_samples) continue;
    if (series.size(TiffAxis::channel) > 1) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected channels of one number per pixel, found {} channels of "
                              "{}: save one channel as a separate file",
                              path.string(), series.size(TiffAxis::channel), samples));
    }
    series.in_samples = TiffAxis::channel;
    series.size(TiffAxis::channel) = samples;
  }
  return all;
}

}  // namespace isosplat::import
