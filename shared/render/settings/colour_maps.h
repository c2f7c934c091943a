#pragma once

#include <cstdint>

#include "shared/render/settings/render_settings.h"

namespace isosplat::render {

/// sRGB colours of each ColourMap, from low to high.
extern const uint8_t kColourMapTable[kColourMaps][256][3];

}  // namespace isosplat::render
