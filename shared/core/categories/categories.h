#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace isosplat {

/// A value of a field whose values are labels, such as the regions of an atlas.
struct Category {
  int64_t value = 0;
  std::string name;                    ///< UTF-8; may be empty
  std::array<uint8_t, 3> colour = {};  ///< sRGB
};

/// The largest size of a value: values of points and vertices are of single precision.
inline constexpr int64_t kMaxCategory = int64_t{1} << 24;
inline constexpr size_t kMaxCategories = 512;  ///< of a field
inline constexpr int64_t kMaxCategorySpan =
    65533;  ///< of its values, from the least to the greatest
/// Limit of categories_json(), of the 16 KiB that metadata may have. All values and colours fit.
inline constexpr size_t kMaxCategoryBytes = 11'500;

/// The entry "categories" of metadata (FORMAT.md), as JSON text: [[3,"#8040c0","liver"],…], of
/// values up to ±kMaxCategory. Names have no control characters, are cut to 64 bytes, and left out
/// where the text would exceed kMaxCategoryBytes. At most kMaxCategories.
std::string categories_json(std::span<const Category> categories);

/// The categories in the metadata of a field, by value, each value once. Empty if its values are no
/// labels. Entries that are malformed, or beyond the limits, are left out; control characters of
/// names too.
std::vector<Category> categories_of(std::string_view metadata);

}  // namespace isosplat
