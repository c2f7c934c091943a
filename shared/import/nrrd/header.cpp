#include "shared/import/nrrd/header.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/text/header_text.h"
#include "shared/import/voxels/data_files.h"

namespace isosplat::import {
namespace {

constexpr size_t kMaxHeader = 1024 * 1024;

/// The first name of fields that have two names.
std::string field_name(std::string_view text) {
  std::string name = lower_case(trimmed(text));
  name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
  if (name == "centerings") return "centers";
  return name;
}

}  // namespace

Result<NrrdHeader> read_nrrd_header(const std::filesystem::path& path) {
  auto beginning = read_beginning(path, kMaxHeader);
  if (!beginning) return tl::unexpected(beginning.error());
  std::string_view rest = *beginning;
  const bool whole_file = rest.size() < kMaxHeader;
  NrrdHeader header;
  auto line = pop_line(rest);
  if (!line || !line->starts_with("NRRD000")) {
    return malformed_nrrd(path, "expected 'NRRD000' and a version in the first line");
  }
  bool ended = false;
  while (!ended) {
    line = pop_line(rest);
    if (!line && whole_file && !rest.empty()) {  // no line end after the last line
      line = rest;
      rest = {};
    }
    if (!line && whole_file) break;  // a detached header need not end with an empty line
    if (!line) return malformed_nrrd(path, "expected an empty line after the header, found none");
    if (line->empty()) break;
    if (line->starts_with('#')) continue;
    const size_t colon = line->find(':');
    if (colon == line->npos)
      return malformed_nrrd(path, fmt::format("no ':' in the line '{}'", *line));
    if (line->substr(colon).starts_with(":=")) {  // a key/value pair for other programs
      header.has_segments = header.has_segments || line->starts_with("Segment0_");
      continue;
    }
    const std::string name = field_name(line->substr(0, colon));
    const std::string_view value = trimmed(line->substr(colon + 1));
    const auto [at, is_new] = header.fields.emplace(name, value);
    if (!is_new && at->second != value) {
      return malformed_nrrd(path, fmt::format("the field '{}' occurs twice, as '{}' and '{}'", name,
                                              at->second, value));
    }
    ended = name == "datafile" && is_list_of_files(value);
  }
  header.data_offset = beginning->size() - rest.size();
  return header;
}

void note_unused_fields(const NrrdHeader& header, std::vector<std::string>& notes) {
  static const std::set<std::string_view> kKnown = {"axismaxs",
                                                    "axismins",
                                                    "blocksize",
                                                    "byteskip",
                                                    "centers",
                                                    "content",
                                                    "datafile",
                                                    "dimension",
                                                    "encoding",
                                                    "endian",
                                                    "kinds",
                                                    "labels",
                                                    "lineskip",
                                                    "max",
                                                    "measurementframe",
                                                    "min",
                                                    "number",
                                                    "oldmax",
                                                    "oldmin",
                                                    "sampleunits",
                                                    "sizes",
                                                    "space",
                                                    "spacedimension",
                                                    "spacedirections",
                                                    "spaceorigin",
                                                    "spaceunits",
                                                    "spacings",
                                                    "thicknesses",
                                                    "type",
                                                    "units"};
  for (const auto& [name, value] : header.fields) {
    if (!kKnown.contains(name)) {
      notes.push_back(fmt::format("the header's field '{}' is unknown: it is ignored", name));
    }
  }
  const std::string_view low = header.field("oldmin"), high = header.field("oldmax");
  if (!low.empty() || !high.empty()) {
    notes.push_back(
        fmt::format("the values were quantized from the range {} to {} ('old min', 'old max'): "
                    "they are read as stored",
                    low, high));
  }
}

tl::unexpected<Error> malformed_nrrd(const std::filesystem::path& path, const std::string& what) {
  return fail(Status::malformed_volume,
              fmt::format("{}: {}: the NRRD header is damaged; export the volume again",
                          path.string(), what));
}

std::optional<VoxelType> nrrd_type(std::string_view text) {
  static const std::map<std::string, VoxelType> kTypes = {
      {"signed char", VoxelType::i8},
      {"int8", VoxelType::i8},
      {"int8_t", VoxelType::i8},
      {"uchar", VoxelType::u8},
      {"unsigned char", VoxelType::u8},
      {"uint8", VoxelType::u8},
      {"uint8_t", VoxelType::u8},
      {"short", VoxelType::i16},
      {"short int", VoxelType::i16},
      {"signed short", VoxelType::i16},
      {"signed short int", VoxelType::i16},
      {"int16", VoxelType::i16},
      {"int16_t", VoxelType::i16},
      {"ushort", VoxelType::u16},
      {"unsigned short", VoxelType::u16},
      {"unsigned short int", VoxelType::u16},
      {"uint16", VoxelType::u16},
      {"uint16_t", VoxelType::u16},
      {"int", VoxelType::i32},
      {"signed int", VoxelType::i32},
      {"int32", VoxelType::i32},
      {"int32_t", VoxelType::i32},
      {"uint", VoxelType::u32},
      {"unsigned int", VoxelType::u32},
      {"uint32", VoxelType::u32},
      {"uint32_t", VoxelType::u32},
      {"longlong", VoxelType::i64},
      {"long long", VoxelType::i64},
      {"long long int", VoxelType::i64},
      {"signed long long", VoxelType::i64},
      {"signed long long int", VoxelType::i64},
      {"int64", VoxelType::i64},
      {"int64_t", VoxelType::i64},
      {"ulonglong", VoxelType::u64},
      {"unsigned long long", VoxelType::u64},
      {"unsigned long long int", VoxelType::u64},
      {"uint64", VoxelType::u64},
      {"uint64_t", VoxelType::u64},
      {"float", VoxelType::f32},
      {"double", VoxelType::f64},
  };
  const auto found = kTypes.find(lower_case(text));
  if (found == kTypes.end()) return std::nullopt;
  return found->second;
}

std::optional<std::vector<std::string>> quoted_strings(std::string_view text) {
  std::vector<std::string> strings;
  for (;;) {
    const size_t begin = text.find('"');
    if (begin == text.npos) return strings;
    const size_t end = text.find('"', begin + 1);
    if (end == text.npos) return std::nullopt;
    strings.emplace_back(text.substr(begin + 1, end - begin - 1));
    text.remove_prefix(end + 1);
  }
}

std::optional<std::vector<double>> parse_vector(std::string_view text) {
  if (!text.starts_with('(') || !text.ends_with(')')) return std::nullopt;
  text = text.substr(1, text.size() - 2);
  std::vector<double> numbers;
  for (;;) {
    const size_t comma = std::min(text.find(','), text.size());
    const auto number = number_in(trimmed(text.substr(0, comma)));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (comma == text.size()) return numbers;
    text.remove_prefix(comma + 1);
  }
}

std::vector<std::string> split_vectors(std::string_view text) {
  std::vector<std::string> all;
  while (!(text = trimmed(text)).empty()) {
    size_t end = text.starts_with('(') ? text.find(')') : text.find_first_of(" \t(");
    if (end == text.npos) end = text.size();
    if (text.starts_with('(') && end < text.size()) ++end;
    all.emplace_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return all;
}

}  // namespace isosplat::import
