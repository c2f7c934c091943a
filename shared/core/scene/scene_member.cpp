#include "shared/core/scene/scene_member.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

namespace isosplat {

using Json = nlohmann::json;

std::string shown_json(const Json& json) {
  constexpr size_t kMost = 40;
  std::string text = json.is_structured()
                         ? std::string(json.is_array() ? "a list of " : "an object of ") +
                               std::to_string(json.size())
                         : json.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > kMost) text = text.substr(0, kMost) + "…";
  return text;
}

SceneMember::SceneMember(const Json* json, std::string path, std::optional<Error>& fault)
    : json_(json), path_(std::move(path)), fault_(fault) {}

bool SceneMember::exists() const {
  return json_ != nullptr && !json_->is_null();
}

SceneMember SceneMember::at(const char* key) const {
  const Json* found = nullptr;
  if (json_ && json_->is_object()) {
    if (const auto it = json_->find(key); it != json_->end()) found = &*it;
  }
  return {found, path_.empty() ? key : path_ + "." + key, fault_};
}

SceneMember SceneMember::at(size_t index) const {
  return {&(*json_)[index], path_ + "[" + std::to_string(index) + "]", fault_};
}

void SceneMember::refuse(const std::string& expected) const {
  if (fault_) return;
  fault_ = Error{Status::malformed_header,
                 "scene: " + (path_.empty() ? "" : path_ + ": ") + "expected " + expected +
                     ", found " + (json_ ? shown_json(*json_) : std::string("nothing"))};
}

void SceneMember::require_object(const char* expected) const {
  if (!json_ || !json_->is_object()) refuse(expected);
}

size_t SceneMember::list(size_t least, size_t most) const {
  if (json_ && json_->is_array() && json_->size() >= least && json_->size() <= most) {
    return json_->size();
  }
  refuse("a list of " + std::to_string(least) +
         (least == most ? "" : " to " + std::to_string(most)));
  return 0;
}

std::string SceneMember::text(size_t most) const {
  if (json_ && json_->is_string()) {
    const auto& found = json_->get_ref<const std::string&>();
    if (found.size() <= most) return found;
  }
  refuse("a text of at most " + std::to_string(most) + " bytes");
  return {};
}

double SceneMember::number(double least, double most) const {
  if (json_ && json_->is_number()) {
    const double found = json_->get<double>();
    if (found >= least && found <= most) return found;
  }
  const auto plain = [](double value) {
    std::string digits = std::to_string(value);
    digits.erase(digits.find_last_not_of('0') + 1, std::string::npos);
    if (digits.back() == '.') digits.pop_back();
    return digits;
  };
  if (std::abs(least) >= kMaxSceneNumber && std::abs(most) >= kMaxSceneNumber) {
    refuse("a finite number");
  } else {
    refuse("a number from " + plain(least) + " to " +
           (most >= kMaxSceneNumber ? "1e300" : plain(most)));
  }
  return std::max(least, std::min(most, 0.0));
}

double SceneMember::integer(double least) const {
  if (json_ && json_->is_number()) {
    const double found = json_->get<double>();
    if (found >= least && found <= kMaxSceneInteger && found == std::floor(found)) return found;
  }
  refuse(least < 0 ? "an integer from -2^53 to 2^53" : "an integer from 0 to 2^53");
  return 0;
}

size_t SceneMember::index(size_t count) const {
  if (!json_ || !json_->is_number()) return 0;
  const double found = json_->get<double>();
  const bool exists = found >= 0 && found < static_cast<double>(count);
  return exists && found == std::floor(found) ? static_cast<size_t>(found) : 0;
}

bool SceneMember::flag() const {
  if (json_ && json_->is_boolean()) return json_->get<bool>();
  refuse("true or false");
  return false;
}

Vec3d SceneMember::vector(double least, double most) const {
  if (list(3, 3) == 0) return {};
  return {at(size_t{0}).number(least, most), at(1).number(least, most), at(2).number(least, most)};
}

std::array<float, 4> SceneMember::colour(bool with_alpha) const {
  std::array<float, 4> colour{0, 0, 0, 1};
  const char* const expected =
      with_alpha ? "a colour as #rrggbb or #rrggbbaa" : "a colour as #rrggbb";
  const std::string found = json_ && json_->is_string() ? json_->get<std::string>() : "";
  const bool is_form = (found.size() == 7 || (with_alpha && found.size() == 9)) &&
                       found[0] == '#' &&
                       found.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
  if (!is_form) {
    refuse(expected);
    return colour;
  }
  for (size_t i = 0; 2 * i + 1 < found.size(); ++i) {
    colour[i] =
        static_cast<float>(std::strtol(found.substr(2 * i + 1, 2).c_str(), nullptr, 16)) / 255;
  }
  return colour;
}

size_t SceneMember::one_of(std::initializer_list<std::string_view> texts) const {
  if (json_ && json_->is_string()) {
    const auto& found = json_->get_ref<const std::string&>();
    const auto at = std::find(texts.begin(), texts.end(), found);
    if (at != texts.end()) return static_cast<size_t>(at - texts.begin());
  }
  std::string expected = "one of ";
  for (const std::string_view text : texts) {
    if (text != *texts.begin()) expected += ", ";
    expected += text;
  }
  refuse(expected);
  return 0;
}

}  // namespace isosplat
