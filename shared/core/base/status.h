#pragma once

#include <string>
#include <utility>

#include "isosplat/status.h"

namespace isosplat {

/// For a function that returns a Result: `return fail(Status::not_found, "…")`.
inline tl::unexpected<Error> fail(Status status, std::string message) {
  return tl::unexpected<Error>(Error{status, std::move(message)});
}

}  // namespace isosplat
