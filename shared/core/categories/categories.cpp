#include "shared/core/categories/categories.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace isosplat {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMaxName = 64;

/// Valid UTF-8 of limited length, without control characters.
std::string clean(std::string text) {
  std::erase_if(text, [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; });
  const std::string dumped =
      Json(text.substr(0, kMaxName)).dump(-1, ' ', true, Json::error_handler_t::ignore);
  return Json::parse(dumped).get<std::string>();
}

std::string hex(const std::array<uint8_t, 3>& colour) {
  std::array<char, 8> text;
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", colour[0], colour[1], colour[2]);
  return text.data();
}

bool read_colour(const Json& json, std::array<uint8_t, 3>& colour) {
  if (!json.is_string()) return false;
  const auto& text = json.get_ref<const std::string&>();
  if (text.size() != 7 || text[0] != '#') return false;
  const auto digit = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
  };
  for (size_t i = 0; i < 3; ++i) {
    const int high = digit(text[1 + 2 * i]), low = digit(text[2 + 2 * i]);
    if (high < 0 || low < 0) return false;
    colour[i] = static_cast<uint8_t>(16 * high + low);
  }
  return true;
}

}  // namespace

std::string categories_json(std::span<const Category> categories) {
  categories = categories.first(std::min(categories.size(), kMaxCategories));
  Json json = Json::array();
  for (const Category& each : categories) {
    json.push_back(Json::array({each.value, hex(each.colour)}));
  }
  size_t bytes = json.dump(-1, ' ', true).size();
  for (size_t i = 0; i < categories.size(); ++i) {
    if (categories[i].name.empty()) continue;
    const Json name = clean(categories[i].name);
    const size_t more = name.dump(-1, ' ', true).size() + 1;
    if (bytes + more > kMaxCategoryBytes) continue;
    bytes += more;
    json[i].push_back(name);
  }
  return json.dump(-1, ' ', true);
}

std::vector<Category> categories_of(std::string_view metadata) {
  std::vector<Category> categories;
  const Json json = Json::parse(metadata, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("categories")) return categories;
  const Json& entries = json.at("categories");
  if (!entries.is_array()) return categories;
  for (const Json& entry : entries) {
    if (categories.size() == kMaxCategories) break;
    if (!entry.is_array() || entry.size() < 2 || !entry[0].is_number_integer()) continue;
    Category category{entry[0].get<int64_t>(), {}, {}};
    if (category.value < -kMaxCategory || category.value > kMaxCategory) continue;
    if (!read_colour(entry[1], category.colour)) continue;
    if (entry.size() > 2 && entry[2].is_string()) {
      category.name = clean(entry[2].get<std::string>());
    }
    categories.push_back(std::move(category));
  }
  std::stable_sort(categories.begin(), categories.end(),
                   [](const Category& a, const Category& b) { return a.value < b.value; });
  const auto last =
      std::unique(categories.begin(), categories.end(),
                  [](const Category& a, const Category& b) { return a.value == b.value; });
  categories.erase(last, categories.end());
  while (!categories.empty() &&
         categories.back().value - categories.front().value > kMaxCategorySpan) {
    categories.pop_back();
  }
  return categories;
}

}  // namespace isosplat
