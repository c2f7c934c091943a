#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "server/catalog/scene_pool.h"
#include "server/http/message.h"

namespace isosplat::server {

/// A byte range of a bundle. Checksums are not verified here: the client verifies them.
class SceneStream final : public BodyStream {
 public:
  /// Requires a range within the bundle.
  SceneStream(std::shared_ptr<const ServedScene> scene, uint64_t offset, uint64_t bytes);
  uint64_t size() const override { return size_; }
  Step next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) override;

 private:
  std::shared_ptr<const ServedScene> scene_;
  uint64_t offset_;
  uint64_t end_;
  uint64_t size_;
};

}  // namespace isosplat::server
