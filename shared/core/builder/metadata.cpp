#include "shared/core/builder/metadata.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "shared/core/preprocess/isovalue_suggestions.h"
#include "shared/core/store/format.h"

namespace isosplat {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint32_t kBins = 256;
constexpr size_t kMaxSuggestions = 5;
constexpr size_t kMaxText = 512;
constexpr size_t kMaxNotes = 3072;  // bytes of all notes
constexpr size_t kKeys = 640;       // bytes of all keys, and of numbers except counts
constexpr size_t kKeysOfOneIsovalue = 320;

/// Text of a file name or header as valid UTF-8 of limited length: JSON must be UTF-8, and a
/// store's header is small.
std::string clean(const std::string& text) {
  const std::string dumped =
      Json(text.substr(0, kMaxText)).dump(-1, ' ', true, Json::error_handler_t::ignore);
  return Json::parse(dumped).get<std::string>();
}

size_t text_bytes(const std::string& text) {
  return Json(clean(text)).dump(-1, ' ', true).size();
}

/// The notes without duplicates, in order, up to kMaxNotes bytes.
Json kept_notes(const std::vector<std::string>& notes) {
  Json kept = Json::array();
  size_t bytes = 0, left_out = 0;
  for (const std::string& note : notes) {
    const std::string text = clean(note);
    if (std::find(kept.begin(), kept.end(), Json(text)) != kept.end()) continue;
    bytes += Json(text).dump(-1, ' ', true).size() + 1;
    if (left_out > 0 || bytes > kMaxNotes) {
      ++left_out;
    } else {
      kept.push_back(text);
    }
  }
  if (left_out > 0) kept.push_back("and " + std::to_string(left_out) + " more notes");
  return kept;
}

/// A value rounded to this number of decimals. Rounded as text: round(value × 10ⁿ) / 10ⁿ can print
/// as 0.30000000000000004.
double rounded(double value, int decimals) {
  std::array<char, 400> text;
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return std::atof(text.data());
}

/// A value with few digits near a quantized isovalue. If voxels are stored exactly, the value is
/// near the middle between two quantized values, so that no voxel equals it. Otherwise it is
/// rounded to three digits of the volume's range.
double round_isovalue(double quantized_isovalue, const ValueMapping& mapping,
                      CellInterval quantized_values) {
  if (mapping.max_error == 0) {
    const double between = mapping.value(std::floor(quantized_isovalue) + 0.5);
    if (mapping.scale == 1) return between;
    for (int decimals = 0; decimals <= 17; ++decimals) {
      const double value = rounded(between, decimals);
      if (std::abs(value - between) <= mapping.scale / 4) return value;
    }
    return between;
  }
  const double value = mapping.value(quantized_isovalue);
  const double range = mapping.value(quantized_values.max) - mapping.value(quantized_values.min);
  if (!(range > 0)) return value;
  const int decimals = 2 - static_cast<int>(std::floor(std::log10(range)));
  if (decimals > 30 || decimals < 0) return value;
  return rounded(value, decimals);
}

ValueHistogram histogram_of(const ValueMapping& mapping, const QuantizedBins& bins,
                            std::vector<uint64_t> counts) {
  // Bins hold whole quantized values: the first bin begins half a step below its smallest one, and
  // the last bin ends half a step above its largest one.
  return {mapping.value(bins.first - 0.5),
          mapping.value(bins.first + double{1} * bins.width * bins.count - 0.5), std::move(counts)};
}

Json to_json(const ValueHistogram& histogram) {
  return {{"low", histogram.low}, {"high", histogram.high}, {"counts", histogram.counts}};
}

/// Size of the metadata that names the volume's file.
size_t source_text_bytes(const StoreOptions& options) {
  if (options.source_file.empty()) return 0;
  constexpr size_t kSourceKeys = sizeof R"(,"file":,"path_hash":)";
  return kSourceKeys + text_bytes(options.source_file) + text_bytes(options.source_path_hash);
}

size_t frame_text_bytes(const VolumeHeader& header) {
  constexpr size_t kKey = sizeof R"(,"frame_of_reference":)";
  return header.frame_of_reference.empty() ? 0 : kKey + text_bytes(header.frame_of_reference);
}

}  // namespace

ValueHistogram value_histogram(const ValueMapping& mapping, const VolumeStatistics& statistics) {
  const QuantizedBins bins = QuantizedBins::over(statistics.range(), kBins);
  return histogram_of(mapping, bins, statistics.histogram(bins));
}

std::vector<double> suggested_isovalues(const ValueMapping& mapping,
                                        const VolumeStatistics& statistics) {
  const CellInterval quantized_values = statistics.range();
  std::vector<double> isovalues = suggest_isovalues(statistics, kMaxSuggestions);
  for (double& isovalue : isovalues) {
    isovalue = round_isovalue(isovalue, mapping, quantized_values);
  }
  return isovalues;
}

size_t metadata_limit(const VolumeHeader& header, const StoreOptions& options) {
  const Index3 n = header.grid.voxels;
  const double voxels = static_cast<double>(n.x) * n.y * n.z;
  const auto digits = std::to_string(static_cast<uint64_t>(voxels)).size();
  const std::string& title = options.title.empty() ? header.name : options.title;
  const size_t text = text_bytes(header.name) + text_bytes(title) + text_bytes(header.format) +
                      text_bytes(options.value_units) +
                      kept_notes(options.notes).dump(-1, ' ', true).size() +
                      source_text_bytes(options) + frame_text_bytes(header);
  if (options.only_isovalue) return std::min(kMaxMetadataBytes, kKeysOfOneIsovalue + text);
  return std::min(kMaxMetadataBytes, kKeys + text + 2 * kBins * (digits + 1));
}

std::string metadata_json(const VolumeHeader& header, const StoreOptions& options,
                          const StoreInfo& info, const VolumeStatistics& statistics) {
  QuantizedBins bins = QuantizedBins::over(info.range, kBins);
  Json json;
  json["name"] = clean(header.name);
  json["title"] = clean(options.title.empty() ? header.name : options.title);
  json["source"] = {{"format", clean(header.format)}, {"type", voxel_type_name(header.type)}};
  if (!options.source_file.empty()) {
    json["source"]["file"] = clean(options.source_file);
    json["source"]["path_hash"] = clean(options.source_path_hash);
  }
  if (!header.frame_of_reference.empty()) {
    json["frame_of_reference"] = clean(header.frame_of_reference);
  }
  if (!options.value_units.empty()) json["units"] = clean(options.value_units);
  if (!options.notes.empty()) json["notes"] = kept_notes(options.notes);
  if (options.only_isovalue) {
    json["suggested_isovalues"] = {*options.only_isovalue};
    const double quantized = info.mapping.quantized_isovalue(*options.only_isovalue);
    bins = {static_cast<uint32_t>(std::clamp(quantized, 0.0, 65535.0)), 1, 1};
  } else {
    json["suggested_isovalues"] = suggested_isovalues(info.mapping, statistics);
    json["histogram"] = to_json(value_histogram(info.mapping, statistics));
  }
  json["active_cells"] = to_json(histogram_of(info.mapping, bins, statistics.active_cells(bins)));
  std::string text = json.dump(-1, ' ', true);
  const size_t limit = metadata_limit(header, options);
  for (const char* expendable : {"active_cells", "histogram", "units", "title", "notes"}) {
    if (text.size() <= limit) break;
    json.erase(expendable);
    text = json.dump(-1, ' ', true);
  }
  return text.size() <= limit ? text : "{}";
}

}  // namespace isosplat
