#include "shared/bindings/wasm/import_text.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "shared/import/volume/hash.h"
#include "shared/import/volume/type_names.h"

namespace isosplat {
namespace {

using Json = nlohmann::ordered_json;

/// The prefix of the flags of allowances; the rest of a flag is the name of its allowance.
constexpr std::string_view kAllow = "--allow-";

tl::unexpected<Error> invalid(const std::string& key, const char* expected) {
  return fail(Status::invalid_argument, "the option \"" + key + "\": expected " + expected);
}

bool is_whole(const Json& json) {
  return json.is_number() && json.get<double>() == std::floor(json.get<double>()) &&
         std::abs(json.get<double>()) <= 9e15;
}

/// Whether `key` is an array of three numbers.
bool has_three(const Json& json, const char* key) {
  return json[key].is_array() && json[key].size() == 3 && json[key][0].is_number() &&
         json[key][1].is_number() && json[key][2].is_number();
}

Result<void> read_allowances(const Json& list, import::Allowances& allowed) {
  if (!list.is_array()) return invalid("allow", "a list of names");
  for (const Json& name : list) {
    bool is_known = false;
    for (const import::AllowanceFlag& known : import::kAllowances) {
      if (!name.is_string() ||
          name.get<std::string>() != std::string_view(known.flag).substr(kAllow.size())) {
        continue;
      }
      allowed.add(known.allowance);
      is_known = true;
    }
    if (!is_known) return invalid("allow", "gaps, truncated, surplus, unplaced or frames");
  }
  return {};
}

Result<void> read_options(const Json& json, import::ImportOptions& options) {
  if (json.contains("dims")) {
    if (!has_three(json, "dims") || !is_whole(json["dims"][0]) || !is_whole(json["dims"][1]) ||
        !is_whole(json["dims"][2])) {
      return invalid("dims", "three whole numbers");
    }
    const auto& dims = json["dims"];
    options.dims = {dims[0].get<int64_t>(), dims[1].get<int64_t>(), dims[2].get<int64_t>()};
    for (const int64_t size : {options.dims->x, options.dims->y, options.dims->z}) {
      if (size < 1 || size > kMaxVoxelsPerAxis) return invalid("dims", "numbers from 1 to 1048576");
    }
  }
  if (json.contains("type")) {
    if (json["type"].is_string()) {
      options.type = import::voxel_type_of(json["type"].get<std::string>());
    }
    if (!options.type) return invalid("type", "u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64");
  }
  if (json.contains("bigEndian")) {
    if (!json["bigEndian"].is_boolean()) return invalid("bigEndian", "true or false");
    options.big_endian = json["bigEndian"].get<bool>();
  }
  if (json.contains("skipBytes")) {
    if (!is_whole(json["skipBytes"]) || json["skipBytes"].get<double>() < 0) {
      return invalid("skipBytes", "a whole number from 0");
    }
    options.skip_bytes = json["skipBytes"].get<uint64_t>();
  }
  if (json.contains("spacing")) {
    if (!has_three(json, "spacing")) return invalid("spacing", "three numbers above 0");
    const auto& spacing = json["spacing"];
    options.spacing = {spacing[0].get<double>(), spacing[1].get<double>(),
                       spacing[2].get<double>()};
    for (const double s : {options.spacing->x, options.spacing->y, options.spacing->z}) {
      if (!(s > 0) || !std::isfinite(s)) return invalid("spacing", "three numbers above 0");
    }
  }
  if (json.contains("timeStep")) {
    if (!is_whole(json["timeStep"])) return invalid("timeStep", "a whole number");
    options.time_step = json["timeStep"].get<int64_t>();
  }
  if (json.contains("channel")) {
    if (!is_whole(json["channel"]) || json["channel"].get<double>() < 0) {
      return invalid("channel", "a whole number from 0");
    }
    options.channel = json["channel"].get<int64_t>();
  }
  if (json.contains("series")) {
    if (!json["series"].is_string()) return invalid("series", "a text");
    options.series = json["series"].get<std::string>();
  }
  if (json.contains("segment")) {
    if (!json["segment"].is_string()) return invalid("segment", "a text");
    options.segment = json["segment"].get<std::string>();
  }
  if (json.contains("dataset")) {
    if (!json["dataset"].is_string()) return invalid("dataset", "a text");
    options.dataset = json["dataset"].get<std::string>();
  }
  if (json.contains("missingValue")) {
    const Json& value = json["missingValue"];
    if (value.is_number()) {
      options.missing_value = value.get<double>();
    } else if (value == "none") {
      options.finds_missing_values = false;
    } else {
      return invalid("missingValue", "a number, or \"none\"");
    }
  }
  if (json.contains("allow")) return read_allowances(json["allow"], options.allowed);
  return {};
}

Json json_of(const std::vector<import::VolumeChoice>& volumes) {
  Json list = Json::array();
  for (const import::VolumeChoice& each : volumes) {
    Json options = Json::object();
    if (!each.dataset.empty()) options["dataset"] = each.dataset;
    if (!each.series.empty()) options["series"] = each.series;
    if (!each.segment.empty()) options["segment"] = each.segment;
    if (each.channel) options["channel"] = *each.channel;
    if (each.time_step) options["timeStep"] = *each.time_step;
    if (each.allowance) {
      options["allow"] = {import::flag_of(*each.allowance).substr(kAllow.size())};
    }
    Json choice = {{"label", each.label}};
    if (!each.name.empty()) choice["name"] = each.name;
    choice["options"] = std::move(options);
    list.push_back(std::move(choice));
  }
  return list;
}

}  // namespace

Result<ImportRequest> parse_import_request(std::string_view text) {
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("path") || !json["path"].is_string()) {
    return fail(Status::invalid_argument, "expected a path and options, as a JSON object");
  }
  ImportRequest request;
  request.path = json["path"].get<std::string>();
  if (json.contains("options") && json["options"].is_object()) {
    if (auto read = read_options(json["options"], request.options); !read) {
      return tl::unexpected(read.error());
    }
  }
  return request;
}

std::string imported_text(const std::filesystem::path& path, const import::OpenVolume& volume,
                          const std::vector<import::VolumeChoice>& choices) {
  const VolumeHeader& header = volume.source->header();
  const VolumeGrid& grid = header.grid;
  // As if the store was written to the volume's folder, like `isosplat build` does by default.
  const std::string file = (path.has_filename() ? path : path.parent_path()).filename().string();
  Json json = {{"voxels", {grid.voxels.x, grid.voxels.y, grid.voxels.z}},
               {"type", voxel_type_name(header.type)},
               {"spacing", {grid.spacing.x, grid.spacing.y, grid.spacing.z}},
               {"origin", {grid.origin.x, grid.origin.y, grid.origin.z}},
               {"direction", grid.direction},
               {"name", header.name},
               {"format", header.format},
               {"frameOfReference", header.frame_of_reference},
               {"slope", header.slope},
               {"intercept", header.intercept},
               {"notes", volume.notes},
               {"sourceFile", file},
               {"sourcePathHash", import::hash_text(file)},
               {"residentBytes", volume.source->resident_bytes()},
               {"files", Json::array()}};
  for (const auto& used : volume.source->files()) json["files"].push_back(used.generic_string());
  if (!choices.empty()) json["choices"] = json_of(choices);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string choices_text(const std::vector<import::VolumeChoice>& volumes) {
  return json_of(volumes).dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace isosplat
