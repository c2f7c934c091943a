#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <map>

#include "native/import/array_source.h"
#include "native/import/data_files.h"
#include "native/import/formats.h"
#include "native/import/header_text.h"

// NRRD (http://teem.sourceforge.net/nrrd/format.html). ITK reads the geometry; where the voxels
// are in which file is read here, so that they can be streamed.
namespace isosplat {
namespace {

struct NrrdHeader {
  std::map<std::string, std::string> fields;  ///< names in lower case, without spaces
  uint64_t data_offset = 0;                   ///< of what follows the header in its file
  std::string geometry_lines;                 ///< all lines but those that say where the data is

  std::string_view field(std::string_view name) const {
    const auto found = fields.find(std::string(name));
    return found == fields.end() ? std::string_view{} : std::string_view(found->second);
  }
};

tl::unexpected<Error> bad(const std::filesystem::path& path, const std::string& what) {
  return fail(Status::malformed_volume,
              fmt::format("{}: {}: the NRRD header is damaged; export the volume again",
                          path.string(), what));
}

Result<NrrdHeader> read_header(const std::filesystem::path& path) {
  auto beginning = read_beginning(path, 1024 * 1024);
  if (!beginning) return tl::unexpected(beginning.error());
  std::string_view rest = *beginning;
  const bool whole_file = rest.size() < 1024 * 1024;
  NrrdHeader header;
  auto line = take_line(rest);
  if (!line || !line->starts_with("NRRD000")) {
    return bad(path, "expected 'NRRD000' and a version in the first line");
  }
  for (;;) {
    line = take_line(rest);
    if (!line && whole_file && !rest.empty()) {  // a detached header's last line may lack its end
      line = rest;
      rest = {};
    }
    if (!line || line->empty()) break;
    if (line->starts_with('#')) continue;
    const size_t colon = line->find(':');
    if (colon == line->npos) return bad(path, fmt::format("no ':' in the line '{}'", *line));
    if (line->substr(colon).starts_with(":=")) continue;  // a key and value for other programs
    std::string name = lower_case(trimmed(line->substr(0, colon)));
    name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
    const std::string_view value = trimmed(line->substr(colon + 1));
    header.fields[name] = std::string(value);
    if (name != "datafile" && name != "encoding" && !name.ends_with("skip")) {
      header.geometry_lines.append(*line).push_back('\n');
    }
    if (name == "datafile" && lower_case(value).starts_with("list")) break;
  }
  header.data_offset = beginning->size() - rest.size();
  return header;
}

std::optional<StoredType> type_of(std::string_view text) {
  static const std::map<std::string_view, StoredType> kTypes = {
      {"signed char", StoredType::i8},
      {"int8", StoredType::i8},
      {"int8_t", StoredType::i8},
      {"uchar", StoredType::u8},
      {"unsigned char", StoredType::u8},
      {"uint8", StoredType::u8},
      {"uint8_t", StoredType::u8},
      {"short", StoredType::i16},
      {"short int", StoredType::i16},
      {"signed short", StoredType::i16},
      {"signed short int", StoredType::i16},
      {"int16", StoredType::i16},
      {"int16_t", StoredType::i16},
      {"ushort", StoredType::u16},
      {"unsigned short", StoredType::u16},
      {"unsigned short int", StoredType::u16},
      {"uint16", StoredType::u16},
      {"uint16_t", StoredType::u16},
      {"int", StoredType::i32},
      {"signed int", StoredType::i32},
      {"int32", StoredType::i32},
      {"int32_t", StoredType::i32},
      {"uint", StoredType::u32},
      {"unsigned int", StoredType::u32},
      {"uint32", StoredType::u32},
      {"uint32_t", StoredType::u32},
      {"longlong", StoredType::i64},
      {"long long", StoredType::i64},
      {"long long int", StoredType::i64},
      {"signed long long", StoredType::i64},
      {"signed long long int", StoredType::i64},
      {"int64", StoredType::i64},
      {"int64_t", StoredType::i64},
      {"ulonglong", StoredType::u64},
      {"unsigned long long", StoredType::u64},
      {"unsigned long long int", StoredType::u64},
      {"uint64", StoredType::u64},
      {"uint64_t", StoredType::u64},
      {"float", StoredType::f32},
      {"double", StoredType::f64},
  };
  const auto found = kTypes.find(text);
  if (found == kTypes.end()) return std::nullopt;
  return found->second;
}

/// Axes that hold the numbers of one voxel, by the names that the specification gives.
bool is_component_kind(std::string_view kind) {
  const std::string k = lower_case(kind);
  return k == "vector" || k == "covariant-vector" || k == "normal" || k == "complex" ||
         k == "stub" || k.ends_with("-color") || k.find("-vector") != k.npos ||
         k.find("-normal") != k.npos || k.find("-gradient") != k.npos ||
         k.find("matrix") != k.npos || k == "quaternion" || k == "point";
}

struct DataFile {
  std::filesystem::path path;
  uint64_t offset = 0;
};

Result<DataFile> find_data_file(const std::filesystem::path& path, const NrrdHeader& header,
                                bool& deflated, std::vector<std::string>& notes) {
  const std::string_view name = header.field("datafile");
  if (name.empty()) return DataFile{path, header.data_offset};
  std::filesystem::path data = std::filesystem::path(std::string(name));
  if (data.is_relative()) data = path.parent_path() / data;
  std::error_code error;
  if (!std::filesystem::exists(data, error)) {
    std::filesystem::path compressed = data;
    compressed += ".gz";
    if (!deflated && std::filesystem::exists(compressed, error)) {
      notes.push_back(fmt::format("{} is missing; {} is read instead", data.filename().string(),
                                  compressed.filename().string()));
      deflated = true;
      return DataFile{compressed, 0};
    }
    return fail(Status::io_error,
                fmt::format("{}: the data file that it names is missing: expected {}: put it "
                            "there, or correct 'data file' in the header",
                            path.string(), data.string()));
  }
  return DataFile{data, 0};
}

/// The geometry, by ITK, which would open the data file even to read the header alone, and stumble
/// over one that is missing: it gets a copy of the header that needs none.
Result<HeaderGeometry> read_geometry(const std::filesystem::path& path, const NrrdHeader& header) {
  const std::string text = "NRRD0005\n" + header.geometry_lines + "encoding: raw\n\n";
  const int memory = ::memfd_create("nrrd-header", MFD_CLOEXEC);
  if (memory < 0 ||
      ::write(memory, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    if (memory >= 0) ::close(memory);
    return fail(Status::out_of_memory, path.string() + ": no memory for a copy of its header");
  }
  auto itk_header = read_itk_header(ItkFormat::nrrd, fmt::format("/proc/self/fd/{}", memory));
  ::close(memory);
  if (!itk_header) {  // name the file, not the copy
    std::string message = itk_header.error().message;
    if (const auto colon = message.find(": "); colon != message.npos) message.erase(0, colon);
    return fail(itk_header.error().status, path.string() + message);
  }
  return itk_header->geometry;
}

/// The offset after `lines` lines of a file. Errors: truncated.
Result<uint64_t> skip_lines(const std::filesystem::path& path, uint64_t offset, int64_t lines) {
  if (lines <= 0) return offset;
  auto text = read_beginning(path, static_cast<size_t>(offset) + 1024 * 1024);
  if (!text) return tl::unexpected(text.error());
  std::string_view rest =
      std::string_view(*text).substr(std::min<size_t>(text->size(), static_cast<size_t>(offset)));
  for (int64_t i = 0; i < lines; ++i) {
    if (!take_line(rest)) return bad(path, "'line skip' goes beyond the file");
  }
  return text->size() - rest.size();
}

}  // namespace

Result<OpenVolume> open_nrrd(const std::filesystem::path& path, const ImportOptions& options) {
  const auto header = read_header(path);
  if (!header) return tl::unexpected(header.error());

  const auto sizes = whole_numbers(header->field("sizes"));
  const auto dimension = whole_number(header->field("dimension"));
  if (!sizes || sizes->empty() || !dimension || *dimension != static_cast<int64_t>(sizes->size())) {
    return bad(path, fmt::format("expected as many sizes as dimensions, found dimension '{}' and "
                                 "sizes '{}'",
                                 header->field("dimension"), header->field("sizes")));
  }
  const auto type = type_of(lower_case(header->field("type")));
  if (!type) return unknown_type(path, header->field("type"));
  const auto kinds = words(header->field("kinds"));
  if (sizes->size() > 3 && !kinds.empty() && is_component_kind(kinds[0])) {
    return not_scalar(path, static_cast<int>(std::min<int64_t>((*sizes)[0], 1000000)));
  }
  const auto step = choose_time_step(path, *sizes, options);
  if (!step) return tl::unexpected(step.error());

  const std::string encoding = lower_case(header->field("encoding"));
  bool deflated = encoding == "gzip" || encoding == "gz";
  const bool raw = encoding == "raw";
  std::vector<std::string> notes;
  if (encoding == "bzip2" || encoding == "bz2") {
    return fail(Status::unsupported_format,
                fmt::format("{}: bzip2-compressed NRRD is not read: save it with encoding gzip or "
                            "raw",
                            path.string()));
  }
  const std::string named = lower_case(header->field("datafile"));
  const bool several_files = named.starts_with("list") || named.find('%') != named.npos;
  if (several_files || (!deflated && !raw)) {
    const auto whole = read_itk_header(ItkFormat::nrrd, path);
    if (!whole) return tl::unexpected(whole.error());
    std::vector<std::filesystem::path> data_files;
    if (several_files) {
      data_files = named_data_files(path, header->field("datafile"));
    } else if (!named.empty()) {
      const auto data = find_data_file(path, *header, deflated, notes);
      if (!data) return tl::unexpected(data.error());
      data_files = {data->path};
    }
    return open_whole(ItkFormat::nrrd, *whole, "NRRD", path, options, std::move(data_files));
  }
  auto data = find_data_file(path, *header, deflated, notes);
  if (!data) return tl::unexpected(data.error());
  const auto geometry = read_geometry(path, *header);
  if (!geometry) return tl::unexpected(geometry.error());

  ArrayVolume array = make_array("NRRD", path, *sizes, *geometry, options);
  array.stored.type = *type;
  const std::string endian = lower_case(header->field("endian"));
  if (stored_bytes(*type) > 1 && endian != "little" && endian != "big") {
    return bad(path, fmt::format("expected endian: little or big, found '{}'", endian));
  }
  array.stored.big_endian = endian == "big";
  array.plain = !deflated;

  const auto lines = whole_number(header->field("lineskip")).value_or(0);
  const auto skip = whole_number(header->field("byteskip")).value_or(0);
  const auto start = skip_lines(data->path, data->offset, lines);
  if (!start) return tl::unexpected(start.error());
  auto bytes = deflated ? open_deflated(data->path, *start) : open_plain(data->path);
  if (!bytes) return tl::unexpected(bytes.error());
  array.offset = deflated ? 0 : *start;
  if (skip >= 0) {
    array.offset += static_cast<uint64_t>(skip);
  } else if (skip == -1 && !deflated) {  // −1: the data is at the end of the file
    array.offset = offset_from_end((*bytes)->size_limit(), *sizes, stored_bytes(*type));
  } else {
    return bad(path, fmt::format("byte skip {} is not possible here", skip));
  }
  array.time_step = *step;
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace isosplat
