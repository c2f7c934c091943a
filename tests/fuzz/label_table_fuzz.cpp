// Tables of labels, in each of their formats. The first byte chooses the format.
#include <cstdlib>

#include "native/labels/label_table.h"

namespace isosplat {
namespace {

void check(const LabelTable& table) {
  if (table.size() > kMaxTableEntries) std::abort();
  const auto is_part = [](float number) { return number >= 0 && number <= 1; };
  for (const auto& [value, entry] : table) {
    if (entry.name.size() > kMaxLabelName || !is_part(entry.opacity)) std::abort();
    if (!entry.colour) continue;
    for (const float channel : *entry.colour) {
      if (!is_part(channel)) std::abort();
    }
  }
}

void check(const Result<LabelTable>& table) {
  if (table) check(*table);
}

void read(uint8_t format, std::string_view text) {
  switch (format % 5) {
    case 0:
      return check(parse_csv_table(text));
    case 1:
      return check(parse_itk_snap_table(text));
    case 2:
      return check(parse_freesurfer_table(text));
    case 3:
      return check(parse_workbench_table(text));
    default:
      return check(parse_slicer_segments(text, 0));
  }
}

}  // namespace
}  // namespace isosplat

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size > 0) isosplat::read(data[0], {reinterpret_cast<const char*>(data + 1), size - 1});
  return 0;
}
