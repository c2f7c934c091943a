#include <fmt/format.h>

#include "native/import/array_source.h"
#include "native/import/formats.h"
#include "native/import/header_text.h"

// Legacy VTK files with structured points. ITK reads geometry and type, and text files; binary
// voxels (always big-endian) are streamed from here.
namespace isosplat {
namespace {

struct VtkLayout {
  bool structured_points = false;
  std::string dataset = "nothing";
  std::optional<uint64_t> binary_offset;  ///< of the first voxel
};

VtkLayout find_layout(std::string_view text) {
  VtkLayout layout;
  const size_t size = text.size();
  std::string_view rest = text;
  take_line(rest);  // the version
  take_line(rest);  // a title, perhaps empty
  bool coding_seen = false, binary = false, scalars = false;
  for (int line_number = 3; line_number < 200; ++line_number) {
    const auto line = take_line(rest);
    if (!line) break;
    const auto parts = words(*line);
    if (parts.empty()) continue;
    const std::string key = lower_case(parts[0]);
    if (!coding_seen) binary = key == "binary";
    coding_seen = true;
    if (key == "dataset" && parts.size() > 1) {
      layout.dataset = lower_case(parts[1]);
      layout.structured_points = layout.dataset == "structured_points";
    }
    if (key == "scalars") scalars = true;
    if (key == "lookup_table") {
      if (binary && scalars) layout.binary_offset = size - rest.size();
      break;
    }
  }
  return layout;
}

}  // namespace

Result<OpenVolume> open_vtk_legacy(const std::filesystem::path& path,
                                   const ImportOptions& options) {
  const auto text = read_beginning(path);
  if (!text) return tl::unexpected(text.error());
  const VtkLayout layout = find_layout(*text);
  if (!layout.structured_points) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected DATASET STRUCTURED_POINTS, found {}: only regular grids "
                            "are volumes; resample it to an image (in ParaView: Resample To "
                            "Image)",
                            path.string(), layout.dataset));
  }
  const auto itk_header = read_itk_header(ItkFormat::vtk, path);
  if (!itk_header) return tl::unexpected(itk_header.error());
  const ItkHeader& info = *itk_header;
  if (!layout.binary_offset) return open_whole(ItkFormat::vtk, info, "VTK", path, options);
  auto array = make_array("VTK", path, info, "unknown", options);
  if (!array) return tl::unexpected(array.error());
  array->stored.big_endian = true;
  array->offset = *layout.binary_offset;
  auto bytes = open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return open_array(std::move(*array), std::move(*bytes));
}

}  // namespace isosplat
