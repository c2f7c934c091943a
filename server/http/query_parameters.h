#pragma once

#include <span>
#include <string_view>

#include "server/http/target.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// A parameter of a route's query. The table of routes has them; requests are checked against it,
/// and the OpenAPI document is made of it.
struct QueryParameter {
  std::string_view name;
  bool is_required = false;
  std::string_view form;         ///< of its values, for messages: "a..b"
  std::string_view description;  ///< for OpenAPI
  std::string_view schema;       ///< of its values, JSON
  std::string_view example{};    ///< JSON; empty: none
};

/// Checks that the query of a target has all parameters that are required, each at most once, and
/// no others. `subject`: begins the message. Errors: invalid_argument, with what was expected.
Result<void> check_query(const Target& target, std::span<const QueryParameter> parameters,
                         std::string_view subject);

}  // namespace isosplat::server
