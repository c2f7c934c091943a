#pragma once

#include <string_view>

namespace isosplat {

/// The description of the routes for programs: openapi.json.
std::string_view openapi_document();

}  // namespace isosplat
