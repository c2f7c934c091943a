#pragma once

#include <chrono>

#include "native/cluster/transport.h"

namespace isosplat {

/// How long a rank that has nothing to do waits until it looks for messages again. Waiting in the
/// transport would occupy a core, which the rank's encoders need.
inline constexpr std::chrono::microseconds kShortPause{100}, kPause{1000};

inline std::chrono::microseconds pause_of(const Transport& transport) {
  return transport.is_busy() ? kShortPause : kPause;
}

}  // namespace isosplat
