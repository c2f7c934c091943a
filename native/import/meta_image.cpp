#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "native/import/array_source.h"
#include "native/import/conventions.h"
#include "native/import/data_files.h"
#include "native/import/formats.h"
#include "native/import/header_text.h"
#include "native/import/text_voxels.h"

// Reads MetaImage: .mha with the voxels in the file, .mhd with the voxels in one or several other
// files.
namespace isosplat {
namespace {

struct MetaHeader {
  std::map<std::string, std::string> fields;
  uint64_t data_offset = 0;

  /// The value of the first of these fields that exists; empty if none does.
  std::string field(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      if (const auto found = fields.find(name); found != fields.end()) return found->second;
    }
    return {};
  }
  bool is_true(std::initializer_list<const char*> names) const {
    const std::string value = lower_case(field(names));
    return value.starts_with('t') || value.starts_with('1') || value.starts_with('y');
  }
};

tl::unexpected<Error> malformed(const std::filesystem::path& path, const std::string& what) {
  return fail(Status::malformed_volume,
              fmt::format("{}: {}: the MetaImage header is damaged; export the volume again",
                          path.string(), what));
}

Result<MetaHeader> read_header(const std::filesystem::path& path) {
  auto text = read_beginning(path);
  if (!text) return tl::unexpected(text.error());
  MetaHeader header;
  std::string_view rest = *text;
  while (!rest.empty()) {
    auto line = pop_line(rest);
    if (!line) {  // the last line of an .mhd may have no line end
      line = rest;
      rest = {};
    }
    size_t equals = line->find('=');
    if (equals == line->npos) equals = line->find(':');
    if (equals == line->npos) {
      if (trimmed(*line).empty()) continue;
      break;
    }
    const std::string name(trimmed(line->substr(0, equals)));
    header.fields[name] = std::string(trimmed(line->substr(equals + 1)));
    if (name == "ElementDataFile") {
      header.data_offset = text->size() - rest.size();
      return header;
    }
  }
  return malformed(path, "expected a line 'ElementDataFile = …', found none");
}

std::optional<VoxelType> type_of(const std::string& name) {
  static const std::map<std::string, VoxelType> kTypes = {
      {"MET_UCHAR", VoxelType::u8},
      {"MET_CHAR", VoxelType::i8},
      {"MET_USHORT", VoxelType::u16},
      {"MET_SHORT", VoxelType::i16},
      {"MET_UINT", VoxelType::u32},
      {"MET_INT", VoxelType::i32},
      {"MET_ULONG", VoxelType::u32},
      {"MET_LONG", VoxelType::i32},  // 4 bytes according to MetaIO
      {"MET_ULONG_LONG", VoxelType::u64},
      {"MET_LONG_LONG", VoxelType::i64},
      {"MET_FLOAT", VoxelType::f32},
      {"MET_DOUBLE", VoxelType::f64}};
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) return std::nullopt;
  return found->second;
}

/// The geometry: world = Offset + Σ index · spacing · row of TransformMatrix, in LPS.
Result<HeaderGeometry> geometry_of(const std::filesystem::path& path, const MetaHeader& header,
                                   size_t dimension, std::vector<std::string>& notes) {
  const auto numbers = [&](std::initializer_list<const char*> names, size_t count,
                           std::vector<double> otherwise) -> Result<std::vector<double>> {
    const std::string text = header.field(names);
    if (text.empty()) return otherwise;
    const auto found = numbers_in(text);
    if (found && found->size() == count) return *found;
    return malformed(
        path, fmt::format("expected {} numbers for {}, found '{}'", count, *names.begin(), text));
  };
  std::vector<double> identity(dimension * dimension, 0.0);
  for (size_t i = 0; i < dimension; ++i) identity[i * dimension + i] = 1;
  const auto spacing =
      numbers({"ElementSpacing", "ElementSize"}, dimension, std::vector<double>(dimension, 1.0));
  if (!spacing) return tl::unexpected(spacing.error());
  if (header.field({"ElementSpacing", "ElementSize"}).empty()) {
    notes.push_back(
        "the header has no voxel spacing: 1,1,1 is assumed; --spacing sets "
        "another");
  }
  const auto offset =
      numbers({"Offset", "Position", "Origin"}, dimension, std::vector<double>(dimension, 0.0));
  if (!offset) return tl::unexpected(offset.error());
  const auto matrix =
      numbers({"TransformMatrix", "Orientation", "Rotation"}, dimension * dimension, identity);
  if (!matrix) return tl::unexpected(matrix.error());

  std::array<Vec3d, 3> steps;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double* row = matrix->data() + axis * dimension;
    if (dimension == 4 && (std::abs(row[3]) > 1e-9 || std::abs((*matrix)[12 + axis]) > 1e-9)) {
      return malformed(path, "expected a TransformMatrix that does not mix space and time");
    }
    const double s = (*spacing)[axis];
    if (s < 0) {
      notes.push_back(
          fmt::format("axis {}: its spacing {} is negative: the axis is reversed", axis + 1, s));
    }
    steps[axis] = Vec3d{row[0], row[1], row[2]} * s;
  }
  HeaderGeometry geometry = geometry_of_steps(steps, {(*offset)[0], (*offset)[1], (*offset)[2]});
  // A spacing of 0 does not change the direction; orient replaces it and adds a note.
  for (size_t axis = 0; axis < 3; ++axis) {
    if ((*spacing)[axis] != 0) continue;
    for (size_t row = 0; row < 3; ++row) {
      geometry.direction[3 * row + axis] = (*matrix)[axis * dimension + row];
    }
  }
  const std::string unit = header.field({"DistanceUnits"});
  if (unit != "?") to_millimetres(unit, geometry, notes);
  return geometry;
}

}  // namespace

Result<OpenVolume> open_meta_image(const std::filesystem::path& path,
                                   const ImportOptions& options) {
  const auto header = read_header(path);
  if (!header) return tl::unexpected(header.error());
  std::vector<std::string> notes;
  const std::string object = lower_case(header->field({"ObjectType"}));
  if (!object.empty() && object != "image") {
    return malformed(path, fmt::format("expected ObjectType = Image, found '{}'", object));
  }
  const auto dimension = whole_number(header->field({"NDims"}));
  const auto sizes = whole_numbers(header->field({"DimSize"}));
  if (!dimension || !sizes || *dimension != static_cast<int64_t>(sizes->size()) || sizes->empty() ||
      std::ranges::min(*sizes) < 1) {
    return malformed(path,
                     fmt::format("expected as many sizes above 0 as dimensions, found NDims '{}' "
                                 "and DimSize '{}'",
                                 header->field({"NDims"}), header->field({"DimSize"})));
  }
  const std::string channels = header->field({"ElementNumberOfChannels"});
  if (!channels.empty() && channels != "1") {
    const auto count = whole_number(channels);
    if (!count || *count < 1) return malformed(path, fmt::format("{} channels", channels));
    return not_scalar(path, static_cast<int>(std::min<int64_t>(*count, 1000)));
  }
  const std::string type_name = header->field({"ElementType"});
  const auto type = type_of(type_name);
  if (!type) return unknown_type(path, type_name.empty() ? "no ElementType" : type_name);
  const auto step = choose_time_step(path, *sizes, options);
  if (!step) return tl::unexpected(step.error());
  if (sizes->size() > 4) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected three axes, or four with time, found {}: save one volume "
                            "as a separate file",
                            path.string(), sizes->size()));
  }
  const auto geometry = geometry_of(path, *header, sizes->size(), notes);
  if (!geometry) return tl::unexpected(geometry.error());

  ArrayVolume array =
      make_array("MetaImage", path, {(*sizes)[0], (*sizes)[1], (*sizes)[2]}, *geometry, options);
  array.stored.type = *type;
  array.steps = static_cast<uint64_t>(sizes->size() > 3 ? (*sizes)[3] : 1);
  array.step = *step;
  array.stored.big_endian = header->is_true({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"});
  const auto number_of = [&](const char* name, double otherwise) {
    const std::string text = header->field({name});
    return text.empty() ? otherwise : number_in(text).value_or(std::nan(""));
  };
  array.stored.slope = number_of("ElementToIntensityFunctionSlope", 1);
  array.stored.intercept = number_of("ElementToIntensityFunctionOffset", 0);
  if (!std::isfinite(array.stored.slope) || array.stored.slope == 0 ||
      !std::isfinite(array.stored.intercept)) {
    return malformed(path,
                     "expected ElementToIntensityFunctionSlope and Offset to be numbers, the slope "
                     "not 0");
  }
  const std::string skip_text = header->field({"HeaderSize"});
  const auto skip = skip_text.empty() ? int64_t{0} : whole_number(skip_text).value_or(-2);
  if (skip < -1) return malformed(path, fmt::format("HeaderSize '{}' is not valid", skip_text));
  const bool deflated = header->is_true({"CompressedData"});
  const std::string binary = header->field({"BinaryData"});
  const bool text = !binary.empty() && !header->is_true({"BinaryData"});
  const uint64_t all = array_bytes(array.voxels, array.steps, voxel_bytes(*type));

  const std::string data_name = header->field({"ElementDataFile"});
  const std::string lower_name = lower_case(data_name);
  const bool local = lower_name == "local";
  if (lower_name.starts_with("list") ||
      (data_name.find('%') != data_name.npos && words(data_name).size() >= 3)) {
    DataFiles files;
    files.paths = named_data_files(path, data_name);
    if (text || deflated) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected uncompressed binary voxels, since there are several "
                              "data files: save the volume as one file",
                              path.string()));
    }
    if (files.paths.empty() || !divides_axes(files.paths.size(), *sizes)) {
      return malformed(path,
                       fmt::format("expected a data file for each step of the last axes, found {} "
                                   "files",
                                   files.paths.size()));
    }
    files.voxel_bytes = voxel_bytes(*type);
    files.bytes_each = all / files.paths.size();
    files.skip = skip;
    auto joined = open_data_files(path, std::move(files), array.allowed);
    if (!joined) return tl::unexpected(joined.error());
    array.missing = std::move(joined->missing);
    for (std::string& note : joined->notes) notes.push_back(std::move(note));
    return open_array(std::move(array), std::move(joined->reader), std::move(notes));
  }

  std::filesystem::path data = path;
  if (!local) {
    data = std::filesystem::path(data_name);
    if (data.is_relative()) data = path.parent_path() / data;
    std::error_code error;
    if (!std::filesystem::exists(data, error)) {
      return fail(Status::io_error,
                  fmt::format("{}: its data file is missing: expected {}: add the file, or correct "
                              "ElementDataFile in the header",
                              path.string(), data.string()));
    }
  }
  const uint64_t start =
      (local ? header->data_offset : 0) + (skip > 0 ? static_cast<uint64_t>(skip) : 0);
  if (skip == -1 && (deflated || text)) {
    return malformed(path, "HeaderSize = -1 is not valid for text and compressed data");
  }
  array.plain = !deflated && !text;
  if (text) array.stored.big_endian = std::endian::native == std::endian::big;
  auto bytes = deflated ? open_deflated(data, start)
               : text   ? open_text_voxels(data, start, *type)
                        : open_plain(data);
  if (!bytes) return tl::unexpected(bytes.error());
  if (array.plain) {
    const uint64_t size = (*bytes)->size_limit();
    array.offset = skip == -1 ? size - std::min(size, all) : start;
  }
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace isosplat
