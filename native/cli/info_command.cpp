#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "native/builder/survey.h"
#include "native/cli/building.h"
#include "native/cli/chunk_report.h"
#include "native/cli/chunk_report_text.h"
#include "native/cli/command.h"
#include "native/cli/histogram_text.h"
#include "native/cli/info_scene.h"
#include "native/cli/mapping_text.h"
#include "native/cli/options.h"
#include "native/cli/remote_flags.h"
#include "native/cli/terminal.h"
#include "native/cli/thumbnail.h"
#include "native/remote/remote_target.h"
#include "shared/core/builder/metadata.h"
#include "shared/core/categories/categories.h"
#include "shared/system/scene_file/scene_file.h"
#include "shared/system/store_file/field_file.h"

namespace isosplat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct InfoCall {
  std::string path;
  VolumeFlags volume_flags;
  RemoteFlags remote_flags;
  bool json = false, chunks = false;
  std::filesystem::path pictures;  ///< the folder for pictures of suggested isovalues; empty: none
};

/// A file with the picture of an isovalue.
struct DrawnIsovalue {
  double isovalue = 0;
  std::string file;
};

Json to_json(Vec3d v) {
  return {v.x, v.y, v.z};
}

Json to_json(Index3 v) {
  return {v.x, v.y, v.z};
}

bool is_sheared(const VolumeGrid& grid) {
  return shear_degrees(grid.direction) >= kMinShearDegrees;
}

Json grid_json(const VolumeGrid& grid) {
  Json levels = Json::array();
  for (uint32_t level = 0; level < level_count(grid.voxels); ++level) {
    const LevelGrid one = level_grid(grid.voxels, level);
    levels.push_back({{"cells", to_json(one.cells)}, {"blocks", to_json(one.blocks)}});
  }
  return {{"voxels", to_json(grid.voxels)},
          {"spacing", to_json(grid.spacing)},
          {"origin", to_json(grid.origin)},
          {"direction", grid.direction},
          {"shearDegrees", is_sheared(grid) ? shear_degrees(grid.direction) : 0.0},
          {"levels", std::move(levels)}};
}

std::string triple(Vec3d v) {
  return fmt::format("{:.6g} × {:.6g} × {:.6g}", v.x, v.y, v.z);
}

void print_line(std::string_view label, std::string_view text) {
  fmt::print("{:<14}{}\n", label, printable(text));
}

void print_notes(const std::vector<std::string>& notes) {
  for (const std::string& text : notes) print_line("note", text);
}

void print_grid(const VolumeGrid& grid) {
  const Index3 n = grid.voxels;
  print_line("dims", fmt::format("{} × {} × {} voxels", n.x, n.y, n.z));
  print_line("spacing", triple(grid.spacing));
  print_line("origin", triple(grid.origin));
  if (grid.direction != kIdentity3) {
    std::string text;
    for (size_t i = 0; i < 9; ++i) {
      text += fmt::format("{}{:.4g}", i == 0 ? "" : i % 3 == 0 ? " | " : " ", grid.direction[i]);
    }
    print_line("direction", text);
  }
  if (is_sheared(grid)) {
    print_line("axes", fmt::format("not perpendicular: {:.1f}° of shear, as the header states",
                                   shear_degrees(grid.direction)));
  }
}

/// `frame`: as FORMAT.md names it; empty: unknown.
void print_frame(const std::string& frame) {
  if (!frame.empty()) print_line("frame", frame);
}

void print_levels(const VolumeGrid& grid) {
  uint64_t blocks = 0;
  const uint32_t levels = level_count(grid.voxels);
  for (uint32_t level = 0; level < levels; ++level) {
    blocks += level_grid(grid.voxels, level).block_count();
  }
  print_line("levels", fmt::format("{} with {} blocks", levels, with_commas(blocks)));
}

void print_suggested(const std::vector<double>& isovalues) {
  if (isovalues.empty()) return;
  std::string text;
  for (const double isovalue : isovalues) text += fmt::format("{:.6g}  ", isovalue);
  print_line("try isovalues", text);
}

void print_histogram(double low, double high, const std::vector<double>& counts) {
  fmt::print("histogram (bars are logarithmic)\n{}", histogram_text(low, high, counts, 16));
}

// Volumes -----------------------------------------------------------------------------------------

int run_volume(const InfoCall& call) {
  const auto options = call.volume_flags.options();
  if (!options) return report(options.error());
  auto opened = import::open_volume(call.path, *options);
  if (!opened) return report(opened.error());
  const VolumeHeader& header = opened->source->header();
  if (call.chunks) note("--chunks has no effect: this is a volume, not a store");
  const auto survey = survey_volume(*opened->source);
  if (!survey) return report(survey.error());
  const auto suggested = suggested_isovalues(survey->mapping, survey->statistics);
  const ValueHistogram histogram = value_histogram(survey->mapping, survey->statistics);
  const VolumeGrid& grid = header.grid;
  const uint64_t bytes = static_cast<uint64_t>(grid.voxels.x) *
                         static_cast<uint64_t>(grid.voxels.y) *
                         static_cast<uint64_t>(grid.voxels.z) * voxel_bytes(header.type);
  if (call.json) {
    Json json = {{"kind", "volume"},        {"name", header.name},
                 {"format", header.format}, {"type", voxel_type_name(header.type)},
                 {"bytes", bytes},          {"residentBytes", opened->source->resident_bytes()}};
    json.update(grid_json(grid));
    json["frameOfReference"] = header.frame_of_reference;
    json["range"] = {survey->min, survey->max};
    json["slope"] = header.slope;
    json["intercept"] = header.intercept;
    json["mapping"] = mapping_json(survey->mapping);
    json["nonFinite"] = survey->missing;
    json["suggestedIsovalues"] = suggested;
    json["histogram"] = {
        {"low", histogram.low}, {"high", histogram.high}, {"counts", histogram.counts}};
    json["notes"] = opened->notes;
    fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
    return kSuccess;
  }
  print_line("volume", fmt::format("{} ({})", header.name, header.format));
  print_grid(grid);
  print_frame(header.frame_of_reference);
  print_line("type", fmt::format("{}, {}", voxel_type_name(header.type), format_bytes(bytes)));
  print_line("range", fmt::format("{:.8g} to {:.8g}", survey->min, survey->max));
  if (header.slope != 1 || header.intercept != 0) {
    print_line("scaling",
               fmt::format("value = {:.9g} + {:.9g} · voxel", header.intercept, header.slope));
  }
  print_line("as a store", exactness(survey->mapping));
  print_line("non-finite", with_commas(survey->missing) + " voxels");
  print_levels(grid);
  const uint64_t resident = opened->source->resident_bytes();
  print_line("memory", resident == 0 ? "read slice by slice"
                                     : format_bytes(resident) +
                                           ": this format is read into memory as a whole");
  print_notes(opened->notes);
  print_suggested(suggested);
  print_histogram(histogram.low, histogram.high,
                  {histogram.counts.begin(), histogram.counts.end()});
  return kSuccess;
}

// Stores ------------------------------------------------------------------------------------------

/// A number in the metadata of a store; `otherwise` if the key is absent or not a number: the
/// metadata is not trusted.
double number_at(const Json& json, const char* key, double otherwise) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : otherwise;
}

std::string text_at(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::vector<double> numbers_at(const Json& json, const char* key) {
  std::vector<double> numbers;
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array()) return numbers;
  for (const Json& item : *found) {
    if (item.is_number()) numbers.push_back(item.get<double>());
  }
  return numbers;
}

std::vector<std::string> texts_at(const Json& json, const char* key) {
  std::vector<std::string> texts;
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array()) return texts;
  for (const Json& item : *found) {
    if (item.is_string()) texts.push_back(item.get<std::string>());
  }
  return texts;
}

Json member(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_object() ? *found : Json::object();
}

/// The isovalues of --chunks: the suggested ones, and seven evenly spaced over the range of values,
/// each between two quantized values.
std::vector<double> report_isovalues(const StoreInfo& info, const std::vector<double>& suggested) {
  std::vector<double> isovalues = suggested;
  for (int i = 1; i < 8; ++i) {
    const double quantized = info.range.min + (info.range.max - info.range.min) * i / 8.0;
    isovalues.push_back(info.mapping.value(std::floor(quantized) + 0.5));
  }
  std::sort(isovalues.begin(), isovalues.end());
  isovalues.erase(std::unique(isovalues.begin(), isovalues.end()), isovalues.end());
  return isovalues;
}

/// Draws each isovalue into a file of its own, in the folder that the call names.
Result<std::vector<DrawnIsovalue>> draw_isovalues(const StoreFile& store, const InfoCall& call,
                                                  const std::vector<double>& isovalues) {
  std::vector<DrawnIsovalue> drawn;
  const std::string name = std::filesystem::path(call.path).stem().string();
  for (const double isovalue : isovalues) {
    const auto image = picture_of_isovalue(store, isovalue);
    if (!image) return tl::unexpected(image.error());
    const auto file = call.pictures / fmt::format("{}-{:.6g}.png", name, isovalue);
    if (auto written = write_png(file.string(), *image); !written) {
      return tl::unexpected(written.error());
    }
    drawn.push_back({isovalue, file.string()});
  }
  return drawn;
}

/// For each field of a store, how many labels it has; 0: its values are no labels.
Result<std::vector<size_t>> categories_of_fields(const StoreFile& store) {
  std::vector<size_t> counts;
  for (size_t i = 0; i < store.info().fields.size(); ++i) {
    const auto field = open_field(store, i);
    if (!field) return tl::unexpected(field.error());
    counts.push_back(categories_of((*field)->info().metadata).size());
  }
  return counts;
}

int run_store(const InfoCall& call) {
  const auto opened = open_store(call.path, call.remote_flags);
  if (!opened) return report(opened.error());
  const StoreFile& store = **opened;
  const StoreInfo& info = store.info();
  const auto categories = categories_of_fields(store);
  if (!categories) return report(categories.error());
  Json metadata = Json::parse(info.metadata, nullptr, false);
  if (!metadata.is_object()) metadata = Json::object();
  const auto suggested = numbers_at(metadata, "suggested_isovalues");
  const Json source = member(metadata, "source");
  const double low = info.mapping.value(info.range.min), high = info.mapping.value(info.range.max);

  std::optional<ChunkReport> chunks;
  if (call.chunks) {
    auto reported = report_chunks(store, report_isovalues(info, suggested));
    if (!reported) return report(reported.error());
    chunks = std::move(*reported);
  }
  std::vector<DrawnIsovalue> pictures;
  if (!call.pictures.empty()) {
    auto drawn = draw_isovalues(store, call, suggested);
    if (!drawn) return report(drawn.error());
    pictures = std::move(*drawn);
  }
  if (call.json) {
    Json json = {{"kind", "store"}, {"contentId", store.content()}, {"fileBytes", info.file_bytes}};
    json.update(grid_json(info.grid));
    json["range"] = {low, high};
    json["mapping"] = mapping_json(info.mapping);
    json["nonFinite"] = info.missing_voxels;
    json["chunks"] = info.chunk_count;
    json["pages"] = store.pages().size();
    json["fields"] = fields_json(info);
    for (size_t i = 0; i < categories->size(); ++i) {
      if ((*categories)[i] > 0) json["fields"][i]["categories"] = (*categories)[i];
    }
    json["metadata"] = metadata;
    if (chunks) json["chunkReport"] = chunks_json(*chunks);
    for (const auto& [isovalue, file] : pictures) {
      json["pictures"].push_back({{"isovalue", isovalue}, {"file", file}});
    }
    fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
    return kSuccess;
  }
  const std::string title = text_at(metadata, "title"), units = text_at(metadata, "units");
  print_line("store", title.empty() ? text_at(metadata, "name") : title);
  print_line("content", store.content());
  print_grid(info.grid);
  print_frame(text_at(metadata, "frame_of_reference"));
  const std::string type = text_at(source, "type"), format = text_at(source, "format");
  print_line("type", type.empty() ? "unknown"
                                  : fmt::format("{}{}", type,
                                                format.empty() ? "" : " (from " + format + ")"));
  print_line("range",
             fmt::format("{:.8g} to {:.8g}{}{}", low, high, units.empty() ? "" : " ", units));
  print_line("exactness", exactness(info.mapping));
  print_line("non-finite", with_commas(info.missing_voxels) + " voxels");
  print_levels(info.grid);
  print_line("chunks", fmt::format("{} in {} directory pages", with_commas(info.chunk_count),
                                   with_commas(store.pages().size())));
  const Index3 n = info.grid.voxels;
  print_line("size", fmt::format("{} ({:.2f} bytes per voxel)", format_bytes(info.file_bytes),
                                 static_cast<double>(info.file_bytes) /
                                     (static_cast<double>(n.x) * n.y * n.z)));
  for (size_t i = 0; i < info.fields.size(); ++i) {
    const FieldRef& field = info.fields[i];
    const size_t labels = (*categories)[i];
    print_line("field", fmt::format("{}, {}{}", describe(field.info), format_bytes(field.bytes),
                                    labels == 0 ? "" : fmt::format(", {} labels", labels)));
  }
  print_notes(texts_at(metadata, "notes"));
  print_suggested(suggested);
  for (const auto& each : pictures) print_line("picture", each.file);
  const Json histogram = member(metadata, "histogram");
  const auto counts = numbers_at(histogram, "counts");
  if (!counts.empty()) {
    print_histogram(number_at(histogram, "low", low), number_at(histogram, "high", high), counts);
  }
  if (chunks) print_chunks(*chunks);
  return kSuccess;
}

bool is_of_store(const InfoCall& call) {
  if (scene_kind(call.path, call.remote_flags) != SceneKind::none) return false;
  return remote::is_address(call.path) || is_store(call.path) || call.path.ends_with(".isosplat");
}

int run(const InfoCall& call) {
  if (!call.pictures.empty() && !is_of_store(call)) {
    return report({Status::invalid_argument,
                   call.path +
                       ": expected a store, whose suggested isovalues --pictures draws, "
                       "found a scene or a volume: build a store, or leave out --pictures"});
  }
  if (scene_kind(call.path, call.remote_flags) != SceneKind::none) {
    const auto scene = open_scene(call.path, call.remote_flags);
    return scene ? print_scene(*scene, call.json) : report(scene.error());
  }
  return is_of_store(call) ? run_store(call) : run_volume(call);
}

}  // namespace

void add_info_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand("info", "Describe a store, a scene or a volume");
  auto call = std::make_shared<InfoCall>();
  command
      ->add_option("path", call->path,
                   "A store, a scene, a bundle, a volume in a format that isosplat build reads, or "
                   "the address of a store or a bundle")
      ->required();
  command->add_flag("--json", call->json, "Print JSON");
  command->add_flag(
      "--chunks", call->chunks,
      "Stores: print sizes of chunks, bands per block, and the chunks that isovalues need");
  command->add_option(
      "--pictures", call->pictures,
      "Stores: draw each suggested isovalue into this folder, as NAME-ISOVALUE.png");
  call->volume_flags.add_to(*command);
  call->remote_flags.add_to(*command);
  command->footer(
      examples("  isosplat info engine.isosplat\n"
               "  isosplat info engine.isosplat --chunks\n"
               "  isosplat info engine.isosplat --pictures .\n"
               "  isosplat info head.nii.gz --json\n"
               "  isosplat info https://example.org/stores/engine.isosplat\n"));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
