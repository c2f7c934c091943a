#include "native/cli/field_categories.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "native/builder/slice_window.h"
#include "native/labels/label_colours.h"
#include "native/labels/label_table.h"

namespace isosplat::cli {
namespace {

/// The colour of voxels without a label.
constexpr std::array<float, 3> kBackground{0.62f, 0.62f, 0.62f};

/// The distinct values of a volume.
Result<std::set<int64_t>> values_of(const FieldFile& file, VolumeSource& volume) {
  const Index3 n = volume.header().grid.voxels;
  SliceWindow window(volume);
  std::set<int64_t> values;
  double last = std::nan("");
  for (int32_t z = 0; z < n.z; ++z) {
    if (auto held = window.move_to({z, z + 1}); !held) return tl::unexpected(held.error());
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        const double value = window.at(x, y, z);
        if (value == last || std::isnan(value)) continue;  // neighbours are often equal
        last = value;
        if (std::abs(value) > kMaxCategory) {
          return fail(
              Status::malformed_volume,
              fmt::format("field '{}': expected labels of at most ±{} (2^24), found {:.17g}: "
                          "number them anew",
                          file.name, kMaxCategory, value));
        }
        if (value != std::floor(value)) {
          return fail(Status::malformed_volume,
                      fmt::format("field '{}': expected labels, which are integers, found {}: use "
                                  "--field {}={} for other values",
                                  file.name, value, file.name, file.file.string()));
        }
        values.insert(static_cast<int64_t>(value));
        if (values.size() > kMaxCategories) {
          return fail(Status::malformed_volume,
                      fmt::format("field '{}': expected at most {} labels, found more", file.name,
                                  kMaxCategories));
        }
      }
    }
  }
  if (values.empty()) {
    return fail(Status::malformed_volume,
                fmt::format("field '{}': expected labels, found no values", file.name));
  }
  if (*values.rbegin() - *values.begin() > kMaxCategorySpan) {
    return fail(
        Status::malformed_volume,
        fmt::format("field '{}': expected labels that differ by at most {}, found {} to {}: "
                    "number them anew",
                    file.name, kMaxCategorySpan, *values.begin(), *values.rbegin()));
  }
  return values;
}

std::array<uint8_t, 3> bytes_of(const std::array<float, 3>& colour) {
  std::array<uint8_t, 3> bytes{};
  for (size_t i = 0; i < 3; ++i) bytes[i] = static_cast<uint8_t>(std::lround(255 * colour[i]));
  return bytes;
}

}  // namespace

Result<std::vector<Category>> field_categories(const FieldFile& file, VolumeSource& volume) {
  LabelTable table;
  if (file.table.empty()) {
    table = table_in_volume(file.file, file.options.channel.value_or(0));
  } else {
    auto read = read_label_table(file.table);
    if (!read) return tl::unexpected(read.error());
    table = std::move(*read);
  }
  const auto values = values_of(file, volume);
  if (!values) return tl::unexpected(values.error());
  std::vector<Category> categories;
  for (const int64_t value : *values) {
    const auto entry = table.find(value);
    const bool is_listed = entry != table.end();
    Category category{value, is_listed ? entry->second.name : "", {}};
    const auto unlisted = value == 0 ? kBackground : label_colour(value);
    category.colour = bytes_of(is_listed ? entry->second.colour.value_or(unlisted) : unlisted);
    categories.push_back(std::move(category));
  }
  return categories;
}

}  // namespace isosplat::cli
