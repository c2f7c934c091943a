#pragma once

#include <string>

#include "shared/bindings/wasm/layouts.h"

// The declarations of layouts.js, and those of their types, as text.
namespace isosplat::layouts {

std::string javascript(const Constant& constant);
std::string javascript(const Enumeration& enumeration);

/// xBytes, and readX, writeX or xOffsets: see write_layouts.cpp.
std::string javascript(const Record& record);

std::string typescript(const Constant& constant);
std::string typescript(const Enumeration& enumeration);
std::string typescript(const Record& record);

}  // namespace isosplat::layouts
