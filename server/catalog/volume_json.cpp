#include "server/catalog/volume_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/catalog/thumbnail.h"
#include "shared/system/store_file/field_file.h"

namespace isosplat::server {
namespace {

using Json = nlohmann::ordered_json;

/// Deeper nested metadata is omitted: writing JSON is recursive, and a store may be hostile.
constexpr int kMaxMetadataDepth = 32;

Json parse_metadata(const std::string& text) {
  bool too_deep = false;
  const auto check_depth = [&](int depth, Json::parse_event_t, Json&) {
    too_deep = too_deep || depth > kMaxMetadataDepth;
    return !too_deep;
  };
  Json metadata = Json::parse(text, check_depth, /*allow_exceptions=*/false);
  if (too_deep || !metadata.is_object()) return Json::object();
  return metadata;
}

Json triple(Index3 v) {
  return Json::array({v.x, v.y, v.z});
}
Json triple(Vec3d v) {
  return Json::array({v.x, v.y, v.z});
}

std::string json_text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// A histogram of at most `max_bins` bins: neighbouring bins are summed. Null if it is malformed.
Json short_histogram(const Json& histogram, size_t max_bins) {
  const auto low = histogram.find("low");
  const auto high = histogram.find("high");
  const auto counts = histogram.find("counts");
  if (low == histogram.end() || high == histogram.end() || counts == histogram.end() ||
      !low->is_number() || !high->is_number() || !counts->is_array() || counts->empty()) {
    return nullptr;
  }
  const size_t step = (counts->size() + max_bins - 1) / max_bins;
  std::vector<double> sums((counts->size() + step - 1) / step);
  for (size_t i = 0; i < counts->size(); ++i) {
    if (!(*counts)[i].is_number()) return nullptr;
    sums[i / step] += (*counts)[i].get<double>();
  }
  // The last bin may be the sum of fewer bins. Scale it, so that it does not look like a dip.
  if (const size_t rest = counts->size() % step; rest != 0) {
    sums.back() *= static_cast<double>(step) / static_cast<double>(rest);
  }
  return {{"low", *low}, {"high", *high}, {"counts", sums}};
}

/// The number of cells of level 0 that are active at the middle of the bin that contains the
/// isovalue, from the table of the metadata; null if there is no table.
Json active_cells_near(const Json& metadata, double isovalue) {
  const auto table = metadata.find("active_cells");
  if (table == metadata.end() || !table->is_object()) return nullptr;
  const auto low = table->find("low"), high = table->find("high"), counts = table->find("counts");
  if (low == table->end() || high == table->end() || counts == table->end() || !low->is_number() ||
      !high->is_number() || !counts->is_array() || counts->empty()) {
    return nullptr;
  }
  const double first = low->get<double>(), last = high->get<double>();
  if (!(first <= isovalue && isovalue <= last && first < last)) return nullptr;
  const double bin = (isovalue - first) / (last - first) * static_cast<double>(counts->size());
  const Json& count = (*counts)[std::min(static_cast<size_t>(bin), counts->size() - 1)];
  return count.is_number() ? count : Json(nullptr);
}

/// Lists keep texts of at most this many bytes in memory, and leave out longer ones.
constexpr size_t kMaxListText = 1024;

bool is_short_text(const Json& json, Json::const_iterator found) {
  return found != json.end() && found->is_string() &&
         found->get_ref<const std::string&>().size() <= kMaxListText;
}

/// Adds the metadata that the list of volumes shows.
void add_short_metadata(Json& json, const StoreInfo& info) {
  constexpr size_t kShortHistogram = 64;
  const Json metadata = parse_metadata(info.metadata);
  for (const char* key : {"title", "units"}) {
    const auto found = metadata.find(key);
    if (is_short_text(metadata, found)) json[key] = *found;
  }
  const auto source = metadata.find("source");
  if (source != metadata.end() && source->is_object()) {
    const auto type = source->find("type");
    if (is_short_text(*source, type)) json["type"] = *type;
  }
  const auto histogram = metadata.find("histogram");
  if (histogram != metadata.end() && histogram->is_object()) {
    Json counts = short_histogram(*histogram, kShortHistogram);
    if (!counts.is_null()) json["histogram"] = std::move(counts);
  }
}

/// The description of a store in lists, except its name and URL.
void add_summary(Json& json, const std::string& content, const StoreInfo& info) {
  json["contentId"] = content;
  json["fileBytes"] = info.file_bytes;
  json["voxels"] = triple(info.grid.voxels);
  json["spacing"] = triple(info.grid.spacing);
  json["range"] = {info.mapping.value(info.range.min), info.mapping.value(info.range.max)};
  json["levels"] = info.levels;
  add_short_metadata(json, info);
}

}  // namespace

std::string small_letters(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

StoreSummary summary_of(const std::string& name, const StoreFile& store) {
  Json json = {{"name", name}, {"url", "/v1/volumes/" + name}};
  add_summary(json, store.content(), store.info());
  if (read_thumbnail(store.path(), store.content())) {
    json["thumbnail"] = fmt::format("/v1/volumes/{}/{}/thumbnail.webp", name, store.content());
  }
  StoreSummary summary;
  summary.content = store.content();
  if (const auto title = json.find("title"); title != json.end()) {
    summary.title = small_letters(title->get<std::string>());
  }
  summary.list_item = json_text(json);
  return summary;
}

StoreSummary summary_of(const std::string& name, Error error) {
  const Json json = {
      {"name", name},
      {"url", "/v1/volumes/" + name},
      {"error", {{"status", status_name(error.status)}, {"message", error.message}}}};
  StoreSummary summary;
  summary.list_item = json_text(json);
  summary.error = std::move(error);
  return summary;
}

std::string published_volume_json(const PublishedVolume& volume) {
  Json json = {{"name", volume.name}, {"file", volume.file}};
  add_summary(json, volume.content, volume.info);
  if (!volume.thumbnail.empty()) json["thumbnail"] = volume.thumbnail;
  return json_text(json);
}

namespace {

Json mapping_json(const ValueMapping& mapping) {
  return {{"offset", mapping.offset},
          {"scale", mapping.scale},
          {"maxError", mapping.max_error},
          {"bits", mapping.bits},
          {"hasMissing", mapping.has_missing}};
}

/// The fields of a store. Title and units are those of the metadata of each field; a field that
/// cannot be opened has none.
Json fields_json(const StoreFile& store) {
  Json list = Json::array();
  for (size_t i = 0; i < store.info().fields.size(); ++i) {
    const auto& [field, offset, bytes] = store.info().fields[i];
    Json json = {
        {"name", field.name},
        {"range", {field.mapping.value(field.range.min), field.mapping.value(field.range.max)}},
        {"quantizedRange", {field.range.min, field.range.max}},
        {"mapping", mapping_json(field.mapping)},
        {"missingVoxels", field.missing_voxels},
        {"offset", offset},
        {"bytes", bytes}};
    if (const auto opened = open_field(store, i)) {
      const Json metadata = parse_metadata((*opened)->info().metadata);
      for (const char* key : {"title", "units"}) {
        const auto found = metadata.find(key);
        if (is_short_text(metadata, found)) json[key] = *found;
      }
    }
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace

std::string volume_json(std::string_view name, const StoreFile& store) {
  const StoreInfo& info = store.info();
  const ValueMapping& mapping = info.mapping;
  Json level_grids = Json::array();
  for (uint32_t level = 0; level < info.levels; ++level) {
    const LevelGrid grid = level_grid(info.grid.voxels, level);
    level_grids.push_back({{"cells", triple(grid.cells)}, {"blocks", triple(grid.blocks)}});
  }
  const std::string base = fmt::format("/v1/volumes/{}/{}", name, store.content());
  const Json json = {
      {"name", name},
      {"contentId", store.content()},
      {"fileBytes", info.file_bytes},
      {"voxels", triple(info.grid.voxels)},
      {"spacing", triple(info.grid.spacing)},
      {"origin", triple(info.grid.origin)},
      {"direction", info.grid.direction},
      {"range", {mapping.value(info.range.min), mapping.value(info.range.max)}},
      {"quantizedRange", {info.range.min, info.range.max}},
      {"mapping", mapping_json(mapping)},
      {"missingVoxels", info.missing_voxels},
      {"fields", fields_json(store)},
      {"levels", info.levels},
      {"levelGrids", std::move(level_grids)},
      {"chunkCount", info.chunk_count},
      {"pageCount", store.pages().size()},
      {"urls",
       {{"header", base + "/header"},
        {"page", base + "/pages/{page}"},
        {"chunk", base + "/chunks/{level}/{x}.{y}.{z}/{band}"},
        {"chunks", base + "/chunks"},
        {"batch", base + "/batch"},
        {"isovalues", base + "/isovalues"},
        {"samples", base + "/samples"},
        {"file", base + "/file"}}},
      {"metadata", parse_metadata(info.metadata)},
  };
  return json_text(json) + "\n";
}

std::string isovalues_json(const StoreInfo& info, uint32_t level,
                           std::span<const IsovalueNeeds> isovalues) {
  const Json metadata = level == 0 ? parse_metadata(info.metadata) : Json::object();
  Json list = Json::array();
  for (const IsovalueNeeds& needs : isovalues) {
    Json json = {{"isovalue", needs.isovalue},
                 {"chunks", needs.chunks},
                 {"bytes", needs.bytes},
                 {"cells", needs.cells}};
    Json active = active_cells_near(metadata, needs.isovalue);
    if (!active.is_null()) json["activeCells"] = std::move(active);
    list.push_back(std::move(json));
  }
  return json_text({{"level", level}, {"isovalues", std::move(list)}}) + "\n";
}

}  // namespace isosplat::server
