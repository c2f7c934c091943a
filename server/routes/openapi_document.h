#pragma once

#include <string>
#include <string_view>

namespace isosplat::server {

/// The description of the routes for programs (OpenAPI 3.1). Paths and parameters come from the
/// table of routes, descriptions of responses from openapi_parts.json. Generated at the first call.
const std::string& openapi_document();

/// The text of openapi_parts.json: the document with `operations` (summary and responses, by
/// Route::operation) in place of `paths`.
std::string_view openapi_parts();

}  // namespace isosplat::server
