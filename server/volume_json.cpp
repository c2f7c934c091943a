#include "server/volume_json.h"

#include <nlohmann/json.hpp>

namespace isosplat {
namespace {

using Json = nlohmann::ordered_json;

/// Metadata with deeper nesting is omitted: writing JSON is recursive, and a store may be hostile.
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
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
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
  // The last bin may be the sum of fewer bins: scale it, so that it does not look like a dip.
  if (const size_t rest = counts->size() % step; rest != 0) {
    sums.back() *= static_cast<double>(step) / static_cast<double>(rest);
  }
  return {{"low", *low}, {"high", *high}, {"counts", sums}};
}

/// Adds the metadata that the list of volumes shows.
void add_short_metadata(Json& json, const StoreInfo& info) {
  constexpr size_t kShortHistogram = 64;
  const Json metadata = parse_metadata(info.metadata);
  for (const char* key : {"title", "units"}) {
    const auto found = metadata.find(key);
    if (found != metadata.end() && found->is_string()) json[key] = *found;
  }
  const auto source = metadata.find("source");
  if (source != metadata.end() && source->is_object()) {
    const auto type = source->find("type");
    if (type != source->end() && type->is_string()) json["type"] = *type;
  }
  const auto histogram = metadata.find("histogram");
  if (histogram != metadata.end() && histogram->is_object()) {
    Json counts = short_histogram(*histogram, kShortHistogram);
    if (!counts.is_null()) json["histogram"] = std::move(counts);
  }
}

/// What a list says of a store, except its name and address.
void add_summary(Json& json, const CatalogEntry& entry) {
  const StoreInfo& info = entry.store->info();
  json["contentId"] = entry.store->content();
  json["fileBytes"] = info.file_bytes;
  json["voxels"] = triple(info.grid.voxels);
  json["spacing"] = triple(info.grid.spacing);
  json["range"] = {info.mapping.value(info.range.min), info.mapping.value(info.range.max)};
  json["levels"] = info.levels;
  add_short_metadata(json, info);
}

}  // namespace

std::string volume_list_json(std::span<const CatalogEntry* const> entries) {
  Json volumes = Json::array();
  for (const CatalogEntry* const entry : entries) {
    Json json = {{"name", entry->name}, {"url", "/v1/volumes/" + entry->name}};
    if (entry->store) {
      add_summary(json, *entry);
    } else {
      json["error"] = {{"status", status_name(entry->error->status)},
                       {"message", entry->error->message}};
    }
    volumes.push_back(std::move(json));
  }
  return json_text({{"volumes", std::move(volumes)}});
}

std::string published_catalog_json(std::span<const PublishedVolume> published) {
  Json volumes = Json::array();
  for (const PublishedVolume& volume : published) {
    Json json = {{"name", volume.entry->name}, {"file", volume.file}};
    add_summary(json, *volume.entry);
    volumes.push_back(std::move(json));
  }
  return json_text({{"isosplat", "site 1"}, {"volumes", std::move(volumes)}});
}

std::string volume_json(const CatalogEntry& entry) {
  const StoreInfo& info = entry.store->info();
  const ValueMapping& mapping = info.mapping;
  Json level_grids = Json::array();
  for (uint32_t level = 0; level < info.levels; ++level) {
    const LevelGrid grid = level_grid(info.grid.voxels, level);
    level_grids.push_back({{"cells", triple(grid.cells)}, {"blocks", triple(grid.blocks)}});
  }
  const std::string base = "/v1/volumes/" + entry.name + "/" + entry.store->content();
  return json_text({
      {"name", entry.name},
      {"contentId", entry.store->content()},
      {"fileBytes", info.file_bytes},
      {"voxels", triple(info.grid.voxels)},
      {"spacing", triple(info.grid.spacing)},
      {"origin", triple(info.grid.origin)},
      {"direction", info.grid.direction},
      {"range", {mapping.value(info.range.min), mapping.value(info.range.max)}},
      {"quantizedRange", {info.range.min, info.range.max}},
      {"mapping",
       {{"offset", mapping.offset},
        {"scale", mapping.scale},
        {"maxError", mapping.max_error},
        {"bits", mapping.bits},
        {"hasMissing", mapping.has_missing}}},
      {"missingVoxels", info.missing_voxels},
      {"levels", info.levels},
      {"levelGrids", std::move(level_grids)},
      {"chunkCount", info.chunk_count},
      {"pageCount", entry.store->pages().size()},
      {"urls",
       {{"header", base + "/header"},
        {"page", base + "/pages/{page}"},
        {"chunk", base + "/chunks/{level}/{x}.{y}.{z}/{band}"},
        {"chunks", base + "/chunks"},
        {"batch", base + "/batch"},
        {"file", base + "/file"}}},
      {"metadata", parse_metadata(info.metadata)},
  });
}

}  // namespace isosplat
