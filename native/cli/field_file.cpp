#include "native/cli/field_file.h"

#include <fmt/format.h>

#include <charconv>

#include "native/builder/distance_source.h"
#include "shared/core/store/field_sections.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

/// Sets the file and its dataset, as "t.h5#/temperature" names them.
void set_file(std::string file, const import::ImportOptions& options, FieldFile& field) {
  std::error_code ignored;
  const size_t hash = file.rfind('#');
  if (hash != file.npos && !fs::exists(file, ignored)) {
    field.options.dataset = file.substr(hash + 1);
    file.resize(hash);
  }
  field.file = file;
  if (import::format_of_file(field.file) != "raw") return;
  field.options.dims = options.dims;
  field.options.type = options.type;
  field.options.big_endian = options.big_endian;
  field.options.skip_bytes = options.skip_bytes;
}

/// A call such as "distance(seg.nrrd,3,5)": its name, and what is in parentheses.
struct Call {
  std::string name;
  std::optional<std::string> argument;
};

std::optional<Call> parse_call(const std::string& text) {
  const size_t open = text.find('(');
  if (open == text.npos) return Call{text, std::nullopt};
  if (!text.ends_with(')')) return std::nullopt;
  return Call{text.substr(0, open), text.substr(open + 1, text.size() - open - 2)};
}

/// Takes the integers from the end of a list such as "seg.nrrd,3,5", in their order.
std::vector<int64_t> take_integers(std::string& list) {
  std::vector<int64_t> numbers;
  for (size_t comma = list.rfind(','); comma != list.npos; comma = list.rfind(',')) {
    int64_t number = 0;
    const char *begin = list.data() + comma + 1, *end = list.data() + list.size();
    const auto [rest, error] = std::from_chars(begin, end, number);
    if (error != std::errc{} || rest != end) break;
    numbers.insert(numbers.begin(), number);
    list.resize(comma);
  }
  return numbers;
}

/// Labels are not measured values: none of them means "no value".
void set_labels_file(const std::string& file, const import::ImportOptions& options,
                     FieldFile& field) {
  field.options.finds_missing_values = false;
  set_file(file, options, field);
}

/// "distance(seg.nrrd,3,5)".
Result<void> set_distance(std::string file, const import::ImportOptions& options,
                          FieldFile& field) {
  std::error_code ignored;
  field.distance_to.emplace();
  if (!fs::exists(file, ignored)) field.distance_to = take_integers(file);
  field.function = "distance";
  for (const int64_t label : *field.distance_to) {
    if (label < -DistanceSource::kMaxLabel || label > DistanceSource::kMaxLabel) {
      return fail(
          Status::invalid_argument,
          fmt::format("field '{}': expected labels of at most ±2^53, found {}", field.name, label));
    }
    field.function += fmt::format(" {}", label);
  }
  set_labels_file(file, options, field);
  return {};
}

/// "labels(atlas.nii.gz,table.csv)".
Result<void> set_labels(std::string file, const import::ImportOptions& options, FieldFile& field) {
  std::error_code ignored;
  const size_t comma = file.rfind(',');
  if (comma != file.npos && !fs::exists(file, ignored)) {
    field.table = file.substr(comma + 1);
    file.resize(comma);
    if (field.table.empty()) {
      return fail(Status::invalid_argument,
                  fmt::format("field '{}': expected the file of a table after the comma, found "
                              "none: @labels({}) has the names and colours of the file itself",
                              field.name, file));
    }
  }
  field.function = "labels";
  field.is_labels = true;
  set_labels_file(file, options, field);
  return {};
}

/// Sets what a text such as "@gradient" or "@distance(seg.nrrd)" names.
Result<void> set_function(const std::string& text, const import::ImportOptions& options,
                          FieldFile& field) {
  auto call = parse_call(text.substr(1));
  if (call && !call->argument) {
    field.derived = derived_of(call->name);
    field.function = call->name;
    if (field.derived) return {};
  }
  if (call && call->argument) {
    Result<void> set;
    if (call->name == "distance") set = set_distance(*call->argument, options, field);
    if (call->name == "labels") set = set_labels(*call->argument, options, field);
    if (!set || !field.file.empty()) return set;
  }
  return fail(Status::invalid_argument,
              fmt::format("field '{}': expected @gradient, @curvature, @distance(FILE) or "
                          "@labels(FILE), found '{}'",
                          field.name, text));
}

}  // namespace

Result<FieldFile> parse_field_file(const std::string& text, const import::ImportOptions& options) {
  const size_t equals = text.find('=');
  if (equals == text.npos || equals + 1 == text.size()) {
    return fail(Status::invalid_argument,
                fmt::format("--field: expected a name and a volume, such as "
                            "temperature=temperature.nrrd, found '{}'",
                            text));
  }
  FieldFile field{text.substr(0, equals), {}, {}};
  FieldInfo info;
  info.name = field.name;
  if (auto checked = check_field(info); !checked) return tl::unexpected(checked.error());
  field.options.time_step = options.time_step;
  field.options.memory_bytes = options.memory_bytes;
  field.options.allowed = options.allowed;
  field.takes_voxels = options.spacing.has_value();
  const std::string file = text.substr(equals + 1);
  if (file.front() == '@') {
    if (auto set = set_function(file, options, field); !set) return tl::unexpected(set.error());
  } else {
    set_file(file, options, field);
  }
  return field;
}

Result<import::OpenVolume> open_field_file(const FieldFile& file) {
  auto opened = import::open_volume(file.file, file.options);
  if (!opened) return opened;
  if (file.derived) {
    opened->source = std::make_unique<DerivedSource>(std::move(opened->source), *file.derived);
    opened->notes.clear();  // those of the volume itself
  }
  return opened;
}

Result<std::unique_ptr<VolumeSource>> values_of_field(const FieldFile& file,
                                                      std::unique_ptr<VolumeSource> volume,
                                                      const VolumeGrid& grid) {
  if (!file.distance_to) return volume;
  auto distances = DistanceSource::create(file.name, std::move(volume), grid, *file.distance_to,
                                          file.options.memory_bytes);
  if (!distances) return tl::unexpected(distances.error());
  return std::move(*distances);
}

}  // namespace isosplat::cli
