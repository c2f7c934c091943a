#include "shared/core/base/status.h"

#include <array>

namespace isosplat {
namespace {

constexpr std::array kNames = {
#define ISOSPLAT_STATUS_NAME(name, cause) std::string_view(#name),
    ISOSPLAT_STATUSES(ISOSPLAT_STATUS_NAME)
#undef ISOSPLAT_STATUS_NAME
};

constexpr std::array kCauses = {
#define ISOSPLAT_STATUS_CAUSE(name, cause) std::string_view(cause),
    ISOSPLAT_STATUSES(ISOSPLAT_STATUS_CAUSE)
#undef ISOSPLAT_STATUS_CAUSE
};

}  // namespace

std::string_view status_name(Status status) {
  const auto index = static_cast<size_t>(status);
  return index < kNames.size() ? kNames[index] : "unknown";
}

std::string_view status_cause(Status status) {
  const auto index = static_cast<size_t>(status);
  return index < kCauses.size() ? kCauses[index] : "a status of a newer version";
}

}  // namespace isosplat
