#include "server/routes/scene_stream.h"

#include <algorithm>
#include <span>
#include <utility>

#include "server/http/streams.h"

namespace isosplat::server {

SceneStream::SceneStream(std::shared_ptr<const ServedScene> scene, uint64_t offset, uint64_t bytes)
    : scene_(std::move(scene)), offset_(offset), end_(offset + bytes), size_(bytes) {}

BodyStream::Step SceneStream::next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) {
  const size_t begin = out.size();
  const size_t length = std::min<uint64_t>(kPieceBytes, end_ - offset_);
  out.resize(begin + length);
  const auto piece = std::span(out).subspan(begin);
  if (Result<void> read = scene_->bytes.read(offset_, piece, no_wait); !read) {
    out.resize(begin);
    if (no_wait && no_wait->needs_disk) return Step::more;
    error = without_folder(std::move(read.error()), scene_->path.parent_path());
    return Step::broken;
  }
  offset_ += length;
  return offset_ == end_ ? Step::last : Step::more;
}

}  // namespace isosplat::server
