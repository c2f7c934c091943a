#include "shared/bindings/wasm/volume_text.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace isosplat {
namespace {

using Json = nlohmann::ordered_json;

tl::unexpected<Error> invalid(const std::string& key, const char* expected) {
  return fail(Status::invalid_argument,
              "the volume's description, \"" + key + "\": expected " + expected);
}

/// The numbers of an array of this length. Nothing if it is not one.
std::optional<std::vector<double>> numbers(const Json& json, const char* key, size_t count) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array() || found->size() != count) return std::nullopt;
  std::vector<double> result;
  for (const Json& number : *found) {
    const bool is_negative_zero = number == "-0";  // as a text, since JavaScript's JSON has no -0
    if (!number.is_number() && !is_negative_zero) return std::nullopt;
    result.push_back(is_negative_zero ? -0.0 : number.get<double>());
    if (!std::isfinite(result.back())) return std::nullopt;
  }
  return result;
}

std::optional<VoxelType> type_of(const std::string& name) {
  for (uint8_t i = 0; i <= static_cast<uint8_t>(VoxelType::f64); ++i) {
    if (name == voxel_type_name(static_cast<VoxelType>(i))) return static_cast<VoxelType>(i);
  }
  return std::nullopt;
}

/// Sets `text` if the key is there. False if it is not a string.
bool read_text(const Json& json, const char* key, std::string& text) {
  const auto found = json.find(key);
  if (found == json.end()) return true;
  if (!found->is_string()) return false;
  text = found->get<std::string>();
  return true;
}

bool read_number(const Json& json, const char* key, double& number) {
  const auto found = json.find(key);
  if (found == json.end()) return true;
  if (*found == "-0") {
    number = -0.0;
    return true;
  }
  if (!found->is_number()) return false;
  number = found->get<double>();
  return std::isfinite(number);
}

}  // namespace

Result<DescribedVolume> parse_volume(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) {
    return fail(Status::invalid_argument, "the volume's description: expected a JSON object");
  }
  DescribedVolume volume;
  VolumeHeader& header = volume.header;
  StoreOptions& options = volume.options;
  const auto voxels = numbers(json, "voxels", 3);
  if (!voxels) return invalid("voxels", "three numbers");
  for (const double count : *voxels) {
    if (count != std::floor(count) || count < 2 || count > kMaxVoxelsPerAxis) {
      return invalid("voxels", "whole numbers from 2 to 1048576");
    }
  }
  header.grid.voxels = {static_cast<int32_t>((*voxels)[0]), static_cast<int32_t>((*voxels)[1]),
                        static_cast<int32_t>((*voxels)[2])};
  std::string type;
  if (!read_text(json, "type", type) || !type_of(type)) {
    return invalid("type", "u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64");
  }
  header.type = *type_of(type);
  if (json.contains("spacing")) {
    const auto spacing = numbers(json, "spacing", 3);
    if (!spacing || !((*spacing)[0] > 0 && (*spacing)[1] > 0 && (*spacing)[2] > 0)) {
      return invalid("spacing", "three numbers above 0");
    }
    header.grid.spacing = {(*spacing)[0], (*spacing)[1], (*spacing)[2]};
  }
  if (json.contains("origin")) {
    const auto origin = numbers(json, "origin", 3);
    if (!origin) return invalid("origin", "three numbers");
    header.grid.origin = {(*origin)[0], (*origin)[1], (*origin)[2]};
  }
  if (json.contains("direction")) {
    const auto direction = numbers(json, "direction", 9);
    if (direction) {
      std::copy(direction->begin(), direction->end(), header.grid.direction.begin());
    }
    if (!direction || !is_basis(header.grid.direction)) {
      return invalid("direction",
                     "nine numbers, row by row: columns of unit length, not in a plane");
    }
  }
  double encoders = 1, memory = static_cast<double>(options.memory_bytes);
  const struct {
    const char* key;
    std::string* text;
  } texts[] = {{"name", &header.name},
               {"format", &header.format},
               {"title", &options.title},
               {"frameOfReference", &header.frame_of_reference},
               {"units", &options.value_units},
               {"sourceFile", &options.source_file},
               {"sourcePathHash", &options.source_path_hash}};
  for (const auto& [key, to] : texts) {
    if (!read_text(json, key, *to)) return invalid(key, "a text");
  }
  const struct {
    const char* key;
    double* number;
    double least;
  } all_numbers[] = {
      {"slope", &header.slope, -1e300},    {"intercept", &header.intercept, -1e300},
      {"maxError", &options.max_error, 0}, {"fetchWeight", &options.fetch_weight, 1e-6},
      {"encoders", &encoders, 1},          {"memoryBytes", &memory, 0}};
  for (const auto& [key, to, least] : all_numbers) {
    if (!read_number(json, key, *to) || *to < least) return invalid(key, "a number in its range");
  }
  if (header.slope == 0) return invalid("slope", "a number other than 0");
  volume.encoders = static_cast<unsigned>(std::min(encoders, 256.0));
  // WebAssembly has 32-bit addresses.
  options.memory_bytes = static_cast<uint64_t>(std::min(memory, 4e9));
  if (const auto notes = json.find("notes"); notes != json.end()) {
    if (!notes->is_array()) return invalid("notes", "a list of texts");
    for (const Json& note : *notes) {
      if (!note.is_string()) return invalid("notes", "a list of texts");
      options.notes.push_back(note.get<std::string>());
    }
  }
  return volume;
}

std::string report_text(const BuildReport& report) {
  std::string id;
  for (const uint8_t byte : report.info.content_id) {
    id += "0123456789abcdef"[byte >> 4];
    id += "0123456789abcdef"[byte & 15];
  }
  const Json json = {{"contentId", id},
                     {"storeBytes", report.info.file_bytes},
                     {"voxelBytes", report.raw_bytes},
                     {"memoryBytes", report.needed_bytes}};
  return json.dump();
}

}  // namespace isosplat
