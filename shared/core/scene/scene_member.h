#pragma once

#include <array>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"
#include "shared/core/base/vec3.h"

namespace isosplat {

inline constexpr size_t kMaxSceneText = 1024;  ///< of names, units and paths, in bytes
inline constexpr double kMaxSceneNumber = 1e300;
/// 2^53: beyond it, numbers of JSON are rounded.
inline constexpr double kMaxSceneInteger = 9007199254740992.0;

/// The value that was found, short enough for a message.
std::string shown_json(const nlohmann::json& json);

/// A member of a scene's document, with its path for messages. All functions report the first
/// fault, and return a value of their type after it.
class SceneMember {
 public:
  /// `json`: null if the member is absent. It and `fault` must outlive the member.
  SceneMember(const nlohmann::json* json, std::string path, std::optional<Error>& fault);

  /// null is the same as an absent member.
  bool exists() const;
  SceneMember at(const char* key) const;
  /// Of a list, which list() has accepted.
  SceneMember at(size_t index) const;

  void refuse(const std::string& expected) const;
  void require_object(const char* expected) const;
  /// The number of entries of a list; 0 after a fault.
  size_t list(size_t least, size_t most) const;
  /// most: in bytes.
  std::string text(size_t most = kMaxSceneText) const;
  double number(double least = -kMaxSceneNumber, double most = kMaxSceneNumber) const;
  /// Up to kMaxSceneInteger.
  double integer(double least) const;
  /// A whole number below `count`; 0 for anything else, which is no fault.
  size_t index(size_t count) const;
  bool flag() const;
  Vec3d vector(double least = -kMaxSceneNumber, double most = kMaxSceneNumber) const;
  /// "#rrggbb" or, with alpha, "#rrggbbaa".
  std::array<float, 4> colour(bool with_alpha) const;
  /// The index of one of these texts; 0 after a fault.
  size_t one_of(std::initializer_list<std::string_view> texts) const;

 private:
  const nlohmann::json* json_;
  std::string path_;
  std::optional<Error>& fault_;
};

}  // namespace isosplat
