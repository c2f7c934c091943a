#include "shared/import/nrrd/nrrd.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/input_files.h"
#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/nrrd/axes.h"
#include "shared/import/nrrd/header.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/data_files.h"
#include "shared/import/voxels/text_voxels.h"

// Reads NRRD (http://teem.sourceforge.net/nrrd/format.html): finds and decodes the voxels.
namespace isosplat::import {
namespace {

constexpr std::string_view kLayersText =
    " (layers of a segmentation: isosplat build --labels makes a scene of all segments)";

enum class Coding { raw, gzip, text, hex };

struct DataFile {
  std::filesystem::path path;
  uint64_t offset = 0;
};

Result<DataFile> find_data_file(const std::filesystem::path& path, const NrrdHeader& header,
                                Coding& coding, std::vector<std::string>& notes) {
  const std::string_view name = header.field("datafile");
  if (name.empty()) return DataFile{path, header.data_offset};
  std::filesystem::path data = std::filesystem::path(std::string(name));
  if (data.is_relative()) data = path.parent_path() / data;
  if (input_kind(data) == InputKind::none) {
    std::filesystem::path compressed = data;
    compressed += ".gz";
    if (coding == Coding::raw && input_kind(compressed) != InputKind::none) {
      notes.push_back(fmt::format("{} is missing: {} is read instead", data.filename().string(),
                                  compressed.filename().string()));
      coding = Coding::gzip;
      return DataFile{compressed, 0};
    }
    return fail(Status::io_error, fmt::format("{}: its data file is missing: expected {}: add the "
                                              "file, or correct 'data file' in the header",
                                              path.string(), data.string()));
  }
  return DataFile{data, 0};
}

/// The offset after the first `lines` lines of a file. Errors: truncated.
Result<uint64_t> skip_lines(const std::filesystem::path& path, uint64_t offset, int64_t lines) {
  if (lines == 0) return offset;
  if (lines < 0) return malformed_nrrd(path, fmt::format("line skip {} is not valid", lines));
  auto text = read_beginning(path, static_cast<size_t>(offset) + 1024 * 1024);
  if (!text) return tl::unexpected(text.error());
  std::string_view rest =
      std::string_view(*text).substr(std::min<size_t>(text->size(), static_cast<size_t>(offset)));
  for (int64_t i = 0; i < lines; ++i) {
    if (!pop_line(rest)) return malformed_nrrd(path, "'line skip' goes beyond the file");
  }
  return text->size() - rest.size();
}

Result<Coding> coding_of(const std::filesystem::path& path, const NrrdHeader& header) {
  const std::string encoding = lower_case(header.field("encoding"));
  if (encoding == "raw") return Coding::raw;
  if (encoding == "gzip" || encoding == "gz") return Coding::gzip;
  if (encoding == "ascii" || encoding == "text" || encoding == "txt") return Coding::text;
  if (encoding == "hex") return Coding::hex;
  if (encoding.empty()) return malformed_nrrd(path, "expected a field 'encoding', found none");
  return fail(Status::unsupported_format,
              fmt::format("{}: expected encoding raw, gzip, ascii or hex, found '{}': save the "
                          "volume with encoding gzip or raw",
                          path.string(), encoding));
}

/// The value of a skip field; 0 if the field is absent.
Result<int64_t> skip_of(const std::filesystem::path& path, const NrrdHeader& header,
                        const char* name) {
  const std::string_view text = header.field(name);
  if (text.empty()) return 0;
  if (const auto number = whole_number(text)) return *number;
  return malformed_nrrd(path,
                        fmt::format("expected a whole number for '{}', found '{}'", name, text));
}

/// Opens all data files of the header as one reader.
Result<OpenVolume> open_several(const std::filesystem::path& path, const NrrdHeader& header,
                                ArrayVolume array, Coding coding, int64_t byte_skip,
                                int64_t line_skip, std::vector<std::string> notes) {
  DataFiles files;
  files.paths = named_data_files(path, header.field("datafile"));
  if (files.paths.empty()) {
    return malformed_nrrd(path, fmt::format("expected data files, found '{}' and none listed",
                                            header.field("datafile")));
  }
  if ((coding != Coding::raw && coding != Coding::gzip) || line_skip != 0 ||
      (coding == Coding::gzip && byte_skip != 0)) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected encoding raw or gzip and no line skips, since there are "
                            "several data files: save the volume as one file",
                            path.string()));
  }
  const uint64_t all = array_bytes(array.voxels, array.steps, voxel_bytes(array.stored.type));
  // With "LIST 3" and "… 1 20 1 3", several files share the slowest axis; the division does not
  // matter.
  const auto sizes = whole_numbers(header.field("sizes")).value_or(std::vector<int64_t>{});
  const auto parts = words(header.field("datafile"));
  const bool is_list = is_list_of_files(header.field("datafile"));
  const auto sub_dimension =
      parts.size() > (is_list ? 1 : 4) ? whole_number(parts[is_list ? 1 : 4]) : std::nullopt;
  const bool fits = sub_dimension == static_cast<int64_t>(sizes.size())
                        ? all % files.paths.size() == 0
                        : divides_axes(files.paths.size(), sizes);
  if (!fits) {
    return malformed_nrrd(path,
                          fmt::format("expected a data file for each step of the slowest axes, "
                                      "found {} files for sizes '{}'",
                                      files.paths.size(), header.field("sizes")));
  }
  files.voxel_bytes = voxel_bytes(array.stored.type);
  files.bytes_each = all / files.paths.size();
  files.skip = byte_skip;
  files.deflated = coding == Coding::gzip;
  if (byte_skip < -1)
    return malformed_nrrd(path, fmt::format("byte skip {} is not valid", byte_skip));
  auto joined = open_data_files(path, std::move(files), array.allowed);
  if (!joined) return tl::unexpected(joined.error());
  array.missing = std::move(joined->missing);
  for (std::string& note : joined->notes) notes.push_back(std::move(note));
  return open_array(std::move(array), std::move(joined->reader), std::move(notes));
}

/// Opens the array in one data file, or behind the header.
Result<OpenVolume> open_single(const std::filesystem::path& path, const NrrdHeader& header,
                               ArrayVolume array, Coding coding, int64_t byte_skip,
                               int64_t line_skip, std::vector<std::string> notes) {
  const VoxelType type = array.stored.type;
  auto data = find_data_file(path, header, coding, notes);
  if (!data) return tl::unexpected(data.error());
  auto start = skip_lines(data->path, data->offset, line_skip);
  if (!start) return tl::unexpected(start.error());
  if (byte_skip < (coding == Coding::raw ? -1 : 0)) {
    return malformed_nrrd(path,
                          fmt::format("byte skip {} is not valid for this encoding", byte_skip));
  }
  array.plain = coding == Coding::raw;
  Result<std::unique_ptr<ByteReader>> bytes;
  switch (coding) {
    case Coding::raw:
      bytes = open_plain(data->path);
      break;
    case Coding::gzip:
      bytes = open_deflated(data->path, *start);
      break;
    case Coding::text:
      bytes = open_text_voxels(data->path, *start + static_cast<uint64_t>(byte_skip), type);
      break;
    case Coding::hex:
      bytes = open_hex(data->path, *start + static_cast<uint64_t>(byte_skip));
      break;
  }
  if (!bytes) return tl::unexpected(bytes.error());
  if (coding == Coding::raw && byte_skip == -1) {  // the data are at the end of the file
    const uint64_t all = array_bytes(array.voxels, array.steps, voxel_bytes(type));
    const auto offset = offset_before_end(data->path, (*bytes)->size_limit(), *start, all);
    if (!offset) return tl::unexpected(offset.error());
    array.offset = *offset;
  } else if (coding == Coding::raw) {
    array.offset = *start + static_cast<uint64_t>(byte_skip);
  } else if (coding == Coding::gzip) {  // teem skips decompressed bytes
    array.offset = static_cast<uint64_t>(byte_skip);
  }
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace

Result<OpenVolume> open_nrrd(const std::filesystem::path& path, const ImportOptions& options) {
  const auto header = read_nrrd_header(path);
  if (!header) return tl::unexpected(header.error());
  const auto type = nrrd_type(header->field("type"));
  if (!type) return unknown_type(path, header->field("type"));
  auto axes = read_nrrd_axes(path, *header);
  if (!axes) return tl::unexpected(axes.error());
  note_unused_fields(*header, axes->notes);
  const auto count = static_cast<uint64_t>(axes->steps);
  const auto channel = choose_channel(path, axes->are_channels ? count : 1, options, axes->channels,
                                      header->has_segments ? kLayersText : "");
  if (!channel) return tl::unexpected(channel.error());
  const auto step = choose_step(path, axes->are_channels ? 1 : axes->steps, options, axes->times);
  if (!step) return tl::unexpected(step.error());
  auto coding = coding_of(path, *header);
  if (!coding) return tl::unexpected(coding.error());

  ArrayVolume array = make_array("NRRD", path, axes->voxels, axes->geometry, options);
  array.stored.type = *type;
  array.steps = static_cast<uint64_t>(axes->steps);
  array.step_axis = axes->step_axis;
  array.step = axes->are_channels ? *channel : *step;
  const std::string endian = lower_case(header->field("endian"));
  if (voxel_bytes(*type) > 1 && *coding != Coding::text && endian != "little" && endian != "big") {
    return malformed_nrrd(path, fmt::format("expected endian: little or big, found '{}'", endian));
  }
  array.stored.big_endian =
      *coding == Coding::text ? std::endian::native == std::endian::big : endian == "big";

  const auto line_skip = skip_of(path, *header, "lineskip");
  if (!line_skip) return tl::unexpected(line_skip.error());
  const auto byte_skip = skip_of(path, *header, "byteskip");
  if (!byte_skip) return tl::unexpected(byte_skip.error());
  const std::string_view named = header->field("datafile");
  if (is_list_of_files(named) || (named.find('%') != named.npos && words(named).size() >= 4)) {
    return open_several(path, *header, std::move(array), *coding, *byte_skip, *line_skip,
                        std::move(axes->notes));
  }
  return open_single(path, *header, std::move(array), *coding, *byte_skip, *line_skip,
                     std::move(axes->notes));
}

}  // namespace isosplat::import
