#include "shared/import/text/commands.h"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace isosplat::import {

std::string shell_word(const std::filesystem::path& path) {
  const std::string text = path.string();
  const bool is_plain = std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || c >= 0x80 ||
           std::string_view("/._-+,=:@%").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (is_plain && !text.empty() && text[0] != '-') return text;
  std::string quoted = text.starts_with('-') ? "./'" : "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string numpy_index(const std::vector<int64_t>& shape) {
  constexpr int64_t kMostChannels = 4;
  std::vector<int64_t> long_axes;
  std::copy_if(shape.begin(), shape.end(), std::back_inserter(long_axes),
               [](int64_t size) { return size > 1; });
  if (long_axes.size() <= 3) return "...";
  // The last axis has channels if it is shorter than the three before it.
  const bool has_channels =
      shape.back() > 1 && shape.back() <= kMostChannels &&
      shape.back() < *std::min_element(long_axes.end() - 4, long_axes.end() - 1);
  auto surplus = long_axes.size() - 3 - (has_channels ? 1 : 0);
  std::string index;
  for (size_t i = 0; surplus > 0; ++i) {
    index += index.empty() ? "0" : ", 0";
    if (shape[i] > 1) --surplus;
  }
  if (has_channels) index += index.empty() ? "..., 0" : ", ..., 0";
  return index;
}

}  // namespace isosplat::import
