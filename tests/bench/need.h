#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

#include "shared/core/base/status.h"

namespace isosplat {

/// Ends a benchmark's program with a message.
[[noreturn]] inline void die(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::exit(1);
}

/// The value of a result that a benchmark needs. Ends the program if it is an error.
template <class T>
T need(Result<T> result) {
  if (!result) die(result.error().message);
  return std::move(*result);
}
inline void need(Result<void> result) {
  if (!result) die(result.error().message);
}

}  // namespace isosplat
