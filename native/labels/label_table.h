#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"

namespace isosplat {

/// The entry of a table for one label.
struct LabelEntry {
  std::string name;                            ///< may be empty
  std::optional<std::array<float, 3>> colour;  ///< sRGB, 0 … 1
  float opacity = 1;                           ///< 0 … 1
  bool visible = true;
};

/// Names and colours of labels, by value.
using LabelTable = std::map<int64_t, LabelEntry>;

/// Limits of tables, whose files are not trusted.
inline constexpr size_t kMaxTableBytes = size_t{16} << 20;
inline constexpr size_t kMaxTableEntries = 65536;
inline constexpr size_t kMaxLabelName = 256;  ///< bytes; longer names are cut

/// Whether a table makes 0 a label. Tables list their background too, with a name such as
/// "Unknown", or transparent.
bool is_zero_a_label(const LabelTable& table);

/// A table as comma-separated values. The first line names the columns, in any order: value, name,
/// r, g, b (0 … 255) and a (0 … 255), of which only value is required; a column may be empty. Text
/// in double quotes may contain commas, and a doubled quote. Errors: malformed_volume, with the
/// line.
Result<LabelTable> parse_csv_table(std::string_view text);

/// A label description file of ITK-SNAP: lines of value, r, g, b (0 … 255), a (0 … 1), visibility
/// of voxels, visibility of the mesh, and the name in double quotes. Errors: malformed_volume, with
/// the line.
Result<LabelTable> parse_itk_snap_table(std::string_view text);

/// A colour table of FreeSurfer: lines of value, name, r, g, b (0 … 255) and transparency (0 …
/// 255). Errors: malformed_volume, with the line.
Result<LabelTable> parse_freesurfer_table(std::string_view text);

/// The last LabelTable in an XML text of Connectome Workbench: elements Label with the attributes
/// Key, Red, Green, Blue, Alpha (0 … 1). Elements without a valid Key are left out. Empty if there
/// is none.
LabelTable parse_workbench_table(std::string_view xml);

/// The segments in the header of a .seg.nrrd of 3D Slicer: the fields SegmentN_Name, SegmentN_Color
/// (0 … 1) and SegmentN_LabelValue. `layer`: segments of other layers (SegmentN_Layer) are left
/// out. In old files without both fields, segment N is the value 1 of layer N. Empty if there are
/// none.
LabelTable parse_slicer_segments(std::string_view header, int64_t layer);

/// Reads a table in any of these formats. The content determines the format. Errors: io_error;
/// those of the parsers.
Result<LabelTable> read_label_table(const std::filesystem::path& path);

/// The table that a volume's own file contains: NIfTI (Workbench's extension) or NRRD (Slicer's
/// segments of a layer). Empty if there is none, or if it cannot be read.
LabelTable table_in_volume(const std::filesystem::path& path, int64_t layer);

}  // namespace isosplat
