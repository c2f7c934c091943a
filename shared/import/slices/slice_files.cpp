#include "shared/import/slices/slice_files.h"

#include <algorithm>

#include "shared/import/bytes/input_files.h"
#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Removes the leading run of digits and returns it without leading zeros.
std::string_view pop_digits(std::string_view& text) {
  size_t end = 0;
  while (end < text.size() && is_digit(text[end])) ++end;
  std::string_view digits = text.substr(0, end);
  text.remove_prefix(end);
  while (digits.size() > 1 && digits.front() == '0') digits.remove_prefix(1);
  return digits;
}

}  // namespace

bool natural_order(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a, whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view left = pop_digits(a), right = pop_digits(b);
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;
}

std::vector<std::filesystem::path> files_of_folder(
    const std::filesystem::path& folder, const std::vector<std::string_view>& extensions) {
  std::vector<std::filesystem::path> files;
  for (const FolderEntry& entry : folder_entries(folder)) {
    const std::filesystem::path& path = entry.path;
    if (path.filename().string().starts_with('.') || entry.kind != InputKind::file) continue;
    const std::string extension = lower_case(path.extension().string());
    if (extensions.empty() ||
        std::find(extensions.begin(), extensions.end(), extension) != extensions.end()) {
      files.push_back(path);
    }
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    return natural_order(a.filename().string(), b.filename().string());
  });
  return files;
}

}  // namespace isosplat::import
