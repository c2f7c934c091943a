#include "native/cli/durations.h"

#include "native/cli/numbers.h"

namespace isosplat::cli {

std::optional<int64_t> parse_duration(std::string_view text) {
  if (text.empty()) return std::nullopt;
  int64_t unit = 0;
  switch (text.back()) {
    case 's':
      unit = 1;
      break;
    case 'm':
      unit = 60;
      break;
    case 'h':
      unit = 3600;
      break;
    case 'd':
      unit = 86400;
      break;
    default:
      return std::nullopt;
  }
  const auto count = parse_whole_number(text.substr(0, text.size() - 1));
  constexpr int64_t kMaxDays = 3650;
  if (!count || *count < 1 || *count > kMaxDays * 86400 / unit) return std::nullopt;
  return *count * unit;
}

}  // namespace isosplat::cli
