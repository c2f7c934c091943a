#pragma once

#include <fmt/format.h>

#include <new>
#include <system_error>
#include <utility>

#include "shared/core/base/status.h"

namespace isosplat {

/// Runs a part of a build. Memory and threads that the system refuses become an error.
template <class Part>
auto with_refusals(Part&& part) -> decltype(part()) {
  try {
    return part();
  } catch (const std::bad_alloc&) {
    return fail(Status::out_of_memory,
                "the system refused memory while the store was built: close other programs, or "
                "reduce --memory or --threads");
  } catch (const std::system_error& error) {
    return fail(
        Status::out_of_memory,
        fmt::format("cannot start the threads of the build ({}): reduce --threads", error.what()));
  }
}

}  // namespace isosplat
