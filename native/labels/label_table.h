#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace isosplat {

/// What a file says about a label.
struct LabelEntry {
  std::string name;                            ///< may be empty
  std::optional<std::array<float, 3>> colour;  ///< sRGB, 0 … 1
  float opacity = 1;                           ///< 0 … 1
  bool visible = true;
};

/// Names and colours of labels, by value.
using LabelTable = std::map<int64_t, LabelEntry>;

/// Whether a table makes 0 a label. Tables list their background too, with a name such as
/// "Unknown", or transparent.
bool is_zero_a_label(const LabelTable& table);

}  // namespace isosplat
