#pragma once

#include <span>
#include <string_view>

#include "server/http/target.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// A parameter of a route's query, in the table of routes. Requests are checked against this table,
/// and the OpenAPI document is generated from it.
struct QueryParameter {
  std::string_view name;
  bool is_required = false;
  std::string_view form;         ///< of its values, for messages: "a..b"
  std::string_view description;  ///< for OpenAPI
  std::string_view schema;       ///< of its values, JSON
  std::string_view example{};    ///< JSON; empty: none
};

/// Checks that the query of a target has all required parameters, each at most once, and no others.
/// `subject`: begins the message. Errors: invalid_argument, with the expected form.
Result<void> check_query(const Target& target, std::span<const QueryParameter> parameters,
                         std::string_view subject);

}  // namespace isosplat::server
