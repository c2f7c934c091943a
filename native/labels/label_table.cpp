#include "native/labels/label_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <fstream>
#include <sstream>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/codecs/deflated_reader.h"

namespace isosplat {
namespace {

namespace fs = std::filesystem;

/// The first line that is neither empty nor a comment.
std::string_view first_line(std::string_view text) {
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    const size_t begin = line.find_first_not_of(" \t\r");
    if (begin != std::string_view::npos && line[begin] != '#') return line.substr(begin);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

/// Whether the second word of a line is a number.
bool has_number_second(std::string_view line) {
  const size_t blank = line.find_first_of(" \t");
  if (blank == std::string_view::npos) return false;
  const size_t second = line.find_first_not_of(" \t", blank);
  return second != std::string_view::npos &&
         std::isdigit(static_cast<unsigned char>(line[second])) != 0;
}

/// The header extensions of a NIfTI file: the bytes before its voxels.
std::string nifti_extensions(const fs::path& path) {
  constexpr size_t kOffset = 108;  // vox_offset, a float; NIfTI-2: 168, an i64
  auto reader = import::is_gzip(path) ? import::open_deflated(path) : import::open_plain(path);
  std::array<std::byte, 540> header;
  if (!reader || !(*reader)->read(0, header)) return {};
  int32_t size = 0;
  std::memcpy(&size, header.data(), sizeof size);
  double end = 0;
  if (size == 348) {
    float offset = 0;
    std::memcpy(&offset, header.data() + kOffset, sizeof offset);
    end = offset;
  } else if (size == 540) {
    int64_t offset = 0;
    std::memcpy(&offset, header.data() + 168, sizeof offset);
    end = static_cast<double>(offset);
  }
  if (!(end > size && end <= static_cast<double>(kMaxTableBytes))) return {};
  std::string bytes(static_cast<size_t>(end) - static_cast<size_t>(size), '\0');
  if (!(*reader)->read(static_cast<uint64_t>(size), std::as_writable_bytes(std::span(bytes)))) {
    return {};
  }
  return bytes;
}

}  // namespace

bool is_zero_a_label(const LabelTable& table) {
  const auto found = table.find(0);
  if (found == table.end() || found->second.opacity == 0) return false;
  std::string name = found->second.name;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array<std::string_view, 7> kBackgrounds{
      "", "background", "clear label", "none", "null", "unknown", "???"};
  return std::find(kBackgrounds.begin(), kBackgrounds.end(), name) == kBackgrounds.end();
}

Result<LabelTable> read_label_table(const fs::path& path) {
  std::error_code failed;
  const uintmax_t bytes = fs::file_size(path, failed);
  std::ifstream in(path, std::ios::binary);
  if (failed || !in) {
    return fail(Status::io_error,
                fmt::format("{}: expected a table of labels, cannot read it", path.string()));
  }
  if (bytes > kMaxTableBytes) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected a table of labels of at most {} bytes, found {}",
                            path.string(), kMaxTableBytes, bytes));
  }
  std::ostringstream out;
  out << in.rdbuf();
  std::string text = out.str();
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  const std::string_view first = first_line(text);
  Result<LabelTable> table;
  if (first.starts_with('<')) {
    table = parse_workbench_table(text);
  } else if (first.find(',') != std::string_view::npos) {
    table = parse_csv_table(text);
  } else {
    table = has_number_second(first) ? parse_itk_snap_table(text) : parse_freesurfer_table(text);
  }
  if (!table) {
    return fail(table.error().status, fmt::format("{}: {}", path.string(), table.error().message));
  }
  if (table->empty()) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected a table of labels (CSV with a header line, ITK-SNAP, "
                            "FreeSurfer, or XML of Workbench), found no label",
                            path.string()));
  }
  return table;
}

LabelTable table_in_volume(const fs::path& path, int64_t layer) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return {};
  const std::string name = path.filename().string();
  if (name.ends_with(".nii") || name.ends_with(".nii.gz")) {
    return parse_workbench_table(nifti_extensions(path));
  }
  if (name.ends_with(".nrrd") || name.ends_with(".nhdr")) {
    const auto header = import::read_beginning(path, kMaxTableBytes / 4);
    return header ? parse_slicer_segments(*header, layer) : LabelTable{};
  }
  return {};
}

}  // namespace isosplat
