#include "native/cli/label_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>

#include "native/cli/scene_inputs.h"
#include "native/labels/cie_lab.h"
#include "native/labels/table_text.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;
using import::SegmentDescription;
using import::SegmentMap;

/// Hands out a volume that is open already.
std::function<Result<import::OpenVolume>()> opened_once(import::OpenVolume volume) {
  const auto shared = std::make_shared<import::OpenVolume>(std::move(volume));
  return [shared]() -> Result<import::OpenVolume> { return std::move(*shared); };
}

/// Names and colours of segments. If several segments have the same label, such as "Kidney", the
/// meaning of their codes distinguishes them: "Kidney, Right".
LabelTable table_of(const SegmentMap& map, const std::map<std::string, size_t>& uses_of_labels) {
  LabelTable table;
  for (const SegmentDescription& segment : map.segments) {
    LabelEntry& entry = table[segment.number];
    const bool is_clear = !segment.label.empty() && uses_of_labels.at(segment.label) == 1;
    entry.name = label_name(is_clear || segment.meaning.empty() ? segment.label : segment.meaning);
    if (segment.cie_lab) entry.colour = srgb_of_cie_lab(*segment.cie_lab);
  }
  return table;
}

std::vector<LabelInput> inputs_of(std::vector<SegmentMap> maps, const LabelTable& given) {
  std::map<std::string, size_t> uses_of_labels;
  for (const SegmentMap& map : maps) {
    for (const SegmentDescription& segment : map.segments) ++uses_of_labels[segment.label];
  }
  std::vector<LabelInput> inputs;
  for (SegmentMap& map : maps) {
    LabelInput input;
    input.table = given.empty() ? table_of(map, uses_of_labels) : given;
    input.background = map.background;
    input.only = map.only;
    input.open = opened_once(std::move(map.volume));
    inputs.push_back(std::move(input));
  }
  return inputs;
}

}  // namespace

Result<std::vector<LabelInput>> label_inputs(const fs::path& file,
                                             const import::ImportOptions& given,
                                             const LabelTable& table) {
  auto maps = import::open_segments(file, given);
  if (!maps) return tl::unexpected(maps.error());
  if (!maps->empty()) return inputs_of(std::move(*maps), table);
  import::ImportOptions options = given;
  // Labels are not measured values: none of them means "no value".
  options.finds_missing_values = false;
  std::vector<LabelInput> inputs;
  const auto add = [&](int64_t layer, auto open) {
    LabelInput& input = inputs.emplace_back();
    input.table = table.empty() ? table_in_volume(file, layer) : table;
    if (is_zero_a_label(input.table)) input.background.reset();
    input.open = std::move(open);
  };
  if (auto opened = import::open_volume(file, options)) {
    add(options.channel.value_or(0), opened_once(std::move(*opened)));
    return inputs;
  }
  const auto volumes = volumes_of_file(file, options);
  if (!volumes) return tl::unexpected(volumes.error());
  if (volumes->times.size() > 1) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected one volume of labels, found {} time steps: choose one "
                            "with --time-step 0 to --time-step {}",
                            file.string(), volumes->times.size(), volumes->times.size() - 1));
  }
  for (const SceneInput& volume : volumes->volumes) {
    add(volume.options.channel.value_or(0),
        [volume] { return import::open_volume(volume.file, volume.options); });
  }
  return inputs;
}

}  // namespace isosplat::cli
