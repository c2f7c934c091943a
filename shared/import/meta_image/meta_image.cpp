#include "shared/import/meta_image/meta_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <span>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/geometry/conventions.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/data_files.h"
#include "shared/import/voxels/text_voxels.h"

// Reads MetaImage: .mha with the voxels in the file, .mhd with the voxels in one or several other
// files.
namespace isosplat::import {
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
    const std::string_view value = trimmed(line->substr(equals + 1));
    const auto [at, is_new] = header.fields.emplace(name, value);
    if (!is_new && at->second != value && name != "Comment") {
      return malformed(path, fmt::format("the field '{}' occurs twice, as '{}' and '{}'", name,
                                         at->second, value));
    }
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

/// The times of the fourth axis, whose unit MetaImage does not know.
TimeAxis times_of(const MetaHeader& header, const std::vector<int64_t>& sizes) {
  const auto spacing = numbers_in(header.field({"ElementSpacing", "ElementSize"}));
  if (sizes.size() != 4 || !spacing || spacing->size() != 4) return {};
  const auto offset = numbers_in(header.field({"Offset", "Position", "Origin"}));
  const double first = offset && offset->size() == 4 ? (*offset)[3] : 0;
  return TimeAxis::regular(first, (*spacing)[3], sizes[3], "");
}

/// The geometry: world = Offset + Σ index · spacing · row of TransformMatrix, in LPS.
Result<HeaderGeometry> geometry_of(const std::filesystem::path& path, const MetaHeader& header,
                                   size_t dimension, std::vector<std::string>& notes) {
  const auto numbers = [&](std::initializer_list<const char*> names, size_t count,
                           std::vector<double> otherwise) -> Result<std::vector<double>> {
    const std::string text = header.field(names);
    if (text.empty()) return otherwise;
    const auto found = numbers_in(text);
    if (!found || found->size() != count) {
      return malformed(
          path, fmt::format("expected {} numbers for {}, found '{}'", count, *names.begin(), text));
    }
    for (const char* name : names) {  // other names of the same field
      const std::string other = header.field({name});
      if (!other.empty() && other != text && numbers_in(other) != found &&
          std::string_view(name) != "ElementSize") {
        return malformed(path, fmt::format("{} is '{}', but {}, which means the same, is '{}'",
                                           *names.begin(), text, name, other));
      }
    }
    return *found;
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

/// The sizes along all axes, x first.
Result<std::vector<int64_t>> sizes_of(const std::filesystem::path& path, const MetaHeader& header) {
  const auto dimension = whole_number(header.field({"NDims"}));
  auto sizes = whole_numbers(header.field({"DimSize"}));
  if (!dimension || !sizes || *dimension != static_cast<int64_t>(sizes->size()) || sizes->empty() ||
      *std::min_element(sizes->begin(), sizes->end()) < 1) {
    return malformed(path,
                     fmt::format("expected as many sizes above 0 as dimensions, found NDims '{}' "
                                 "and DimSize '{}'",
                                 header.field({"NDims"}), header.field({"DimSize"})));
  }
  return *std::move(sizes);
}

/// The numbers of each voxel.
Result<uint64_t> channels_of(const std::filesystem::path& path, const MetaHeader& header) {
  const std::string text = header.field({"ElementNumberOfChannels"});
  if (text.empty()) return 1;
  const auto count = whole_number(text);
  if (!count || *count < 1 || *count > int64_t{1} << 20) {
    return malformed(path, fmt::format("expected ElementNumberOfChannels from 1 to {}, found '{}'",
                                       int64_t{1} << 20, text));
  }
  return static_cast<uint64_t>(*count);
}

Result<VoxelType> voxel_type_of(const std::filesystem::path& path, const MetaHeader& header) {
  const std::string name = header.field({"ElementType"});
  const auto type = type_of(name);
  if (!type) return unknown_type(path, name.empty() ? "no ElementType" : name);
  return *type;
}

/// The type, byte order, slope and intercept of the voxels.
Result<StoredVoxels> stored_voxels_of(const std::filesystem::path& path, const MetaHeader& header,
                                      VoxelType type) {
  StoredVoxels stored;
  stored.type = type;
  stored.big_endian = header.is_true({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"});
  const auto number_of = [&](const char* name, double otherwise) {
    const std::string text = header.field({name});
    return text.empty() ? otherwise : number_in(text).value_or(std::nan(""));
  };
  stored.slope = number_of("ElementToIntensityFunctionSlope", 1);
  stored.intercept = number_of("ElementToIntensityFunctionOffset", 0);
  if (!std::isfinite(stored.slope) || stored.slope == 0 || !std::isfinite(stored.intercept)) {
    return malformed(path,
                     "expected ElementToIntensityFunctionSlope and Offset to be numbers, the slope "
                     "not 0");
  }
  return stored;
}

/// How the voxels are encoded in the data files.
struct Encoding {
  int64_t skip = 0;  ///< bytes before the voxels; -1: the voxels are at the end of the file
  bool deflated = false;
  bool text = false;
};

Result<Encoding> encoding_of(const std::filesystem::path& path, const MetaHeader& header) {
  Encoding encoding;
  const std::string skip = header.field({"HeaderSize"});
  if (!skip.empty()) encoding.skip = whole_number(skip).value_or(-2);
  if (encoding.skip < -1) return malformed(path, fmt::format("HeaderSize '{}' is not valid", skip));
  encoding.deflated = header.is_true({"CompressedData"});
  encoding.text = !header.field({"BinaryData"}).empty() && !header.is_true({"BinaryData"});
  return encoding;
}

/// Whether ElementDataFile is a list of files or a pattern with a range of numbers.
bool names_several_files(const std::string& data_name) {
  return is_list_of_files(data_name) ||
         (data_name.find('%') != data_name.npos && words(data_name).size() >= 3);
}

/// Opens the array in several data files, which divide the last axes of `sizes`.
Result<OpenVolume> open_several(const std::filesystem::path& path, const std::string& data_name,
                                std::span<const int64_t> sizes, const Encoding& encoding,
                                ArrayVolume array, std::vector<std::string> notes) {
  DataFiles files;
  files.paths = named_data_files(path, data_name);
  if (encoding.text || encoding.deflated) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected uncompressed binary voxels, since there are several "
                            "data files: save the volume as one file",
                            path.string()));
  }
  if (files.paths.empty() || !divides_axes(files.paths.size(), sizes)) {
    return malformed(path, fmt::format("expected a data file for each step of the last axes, found "
                                       "{} files",
                                       files.paths.size()));
  }
  files.voxel_bytes = voxel_bytes(array.stored.type);
  files.bytes_each = array_bytes(array.voxels, array.steps, files.voxel_bytes) / files.paths.size();
  files.skip = encoding.skip;
  auto joined = open_data_files(path, std::move(files), array.allowed);
  if (!joined) return tl::unexpected(joined.error());
  array.missing = std::move(joined->missing);
  for (std::string& note : joined->notes) notes.push_back(std::move(note));
  return open_array(std::move(array), std::move(joined->reader), std::move(notes));
}

/// Finds the one data file, relative to the header's folder.
Result<std::filesystem::path> find_data_file(const std::filesystem::path& path,
                                             const std::string& data_name) {
  std::filesystem::path data = data_name;
  if (data.is_relative()) data = path.parent_path() / data;
  if (input_kind(data) == InputKind::none) {
    return fail(Status::io_error,
                fmt::format("{}: its data file is missing: expected {}: add the file, or correct "
                            "ElementDataFile in the header",
                            path.string(), data.string()));
  }
  return data;
}

/// Opens the array in one data file, or behind the header (ElementDataFile = LOCAL).
Result<OpenVolume> open_single(const std::filesystem::path& path, const MetaHeader& header,
                               const Encoding& encoding, ArrayVolume array,
                               std::vector<std::string> notes) {
  const std::string data_name = header.field({"ElementDataFile"});
  std::filesystem::path data = path;
  uint64_t start = header.data_offset;
  if (lower_case(data_name) != "local") {
    const auto found = find_data_file(path, data_name);
    if (!found) return tl::unexpected(found.error());
    data = *found;
    start = 0;
  }
  if (encoding.skip > 0) start += static_cast<uint64_t>(encoding.skip);
  array.plain = !encoding.deflated && !encoding.text;
  if (encoding.skip == -1 && !array.plain) {
    return malformed(path, "HeaderSize = -1 is not valid for text and compressed data");
  }
  if (encoding.text) array.stored.big_endian = std::endian::native == std::endian::big;
  auto bytes = encoding.deflated ? open_deflated(data, start)
               : encoding.text   ? open_text_voxels(data, start, array.stored.type)
                                 : open_plain(data);
  if (!bytes) return tl::unexpected(bytes.error());
  if (array.plain) {
    const uint64_t all = array_bytes(array.voxels, array.steps, voxel_bytes(array.stored.type));
    const auto offset = encoding.skip == -1
                            ? offset_before_end(data, (*bytes)->size_limit(), start, all)
                            : Result<uint64_t>(start);
    if (!offset) return tl::unexpected(offset.error());
    array.offset = *offset;
  }
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace

Result<OpenVolume> open_meta_image(const std::filesystem::path& path,
                                   const ImportOptions& options) {
  const auto header = read_header(path);
  if (!header) return tl::unexpected(header.error());
  const std::string object = lower_case(header->field({"ObjectType"}));
  if (!object.empty() && object != "image") {
    return malformed(path, fmt::format("expected ObjectType = Image, found '{}'", object));
  }
  const auto sizes = sizes_of(path, *header);
  if (!sizes) return tl::unexpected(sizes.error());
  const auto type = voxel_type_of(path, *header);
  if (!type) return tl::unexpected(type.error());
  const auto channels = channels_of(path, *header);
  if (!channels) return tl::unexpected(channels.error());
  const auto channel = choose_channel(path, *channels, options);
  if (!channel) return tl::unexpected(channel.error());
  const auto step = choose_time_step(path, *sizes, options, times_of(*header, *sizes));
  if (!step) return tl::unexpected(step.error());
  if (sizes->size() > 4) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected three axes, or four with time, found {}: save one volume "
                            "as a separate file",
                            path.string(), sizes->size()));
  }
  std::vector<std::string> notes;
  const auto geometry = geometry_of(path, *header, sizes->size(), notes);
  if (!geometry) return tl::unexpected(geometry.error());
  const auto stored = stored_voxels_of(path, *header, *type);
  if (!stored) return tl::unexpected(stored.error());
  const auto encoding = encoding_of(path, *header);
  if (!encoding) return tl::unexpected(encoding.error());

  ArrayVolume array =
      make_array("MetaImage", path, {(*sizes)[0], (*sizes)[1], (*sizes)[2]}, *geometry, options);
  array.stored = *stored;
  array.steps = static_cast<uint64_t>(sizes->size() > 3 ? (*sizes)[3] : 1);
  array.step = *step;
  const std::string data_name = header->field({"ElementDataFile"});
  if (*channels > 1) {
    if (array.steps > 1 || names_several_files(data_name)) {
      return not_scalar(path, static_cast<int>(*channels));
    }
    array.steps = *channels;
    array.step = *channel;
    array.step_axis = 0;
  }
  if (names_several_files(data_name)) {
    return open_several(path, data_name, *sizes, *encoding, std::move(array), std::move(notes));
  }
  return open_single(path, *header, *encoding, std::move(array), std::move(notes));
}

}  // namespace isosplat::import
