#pragma once

#include <chrono>

#include "native/cluster/transport.h"

namespace isosplat {

/// How long a rank that has nothing to do may wait until it looks for messages again. Waiting in
/// the transport would occupy a core, which the rank's encoders need.
inline std::chrono::microseconds pause_of(const Transport& transport) {
  return std::chrono::microseconds(transport.is_busy() ? 100 : 1000);
}

}  // namespace isosplat
