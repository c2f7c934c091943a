#pragma once

#include "shared/core/store/store_writer.h"

namespace isosplat {

/// The sink of a StoreBuild that writes no store: of a part, or of a field, whose blocks go
/// elsewhere.
class NoSink : public ByteSink {
 public:
  Result<void> write(uint64_t, std::span<const std::byte>) override { return {}; }
};

}  // namespace isosplat
