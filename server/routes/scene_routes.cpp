#include "server/routes/scene_routes.h"

#include <fmt/format.h>

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "server/http/conditions.h"
#include "server/http/streams.h"
#include "server/routes/byte_range.h"
#include "server/routes/compressible_response.h"
#include "server/routes/content_routes.h"
#include "server/routes/json_response.h"
#include "server/routes/volume_routes.h"

namespace isosplat::server {
namespace {

/// A byte range of the bundle that a scene is served as.
std::unique_ptr<FileStream> scene_stream(std::shared_ptr<const ServedScene> scene, uint64_t offset,
                                         uint64_t bytes) {
  const auto read = [scene = std::move(scene)](uint64_t at, std::span<std::byte> out,
                                               NoWait* no_wait) -> Result<void> {
    auto done = scene->bytes.read(at, out, no_wait);
    if (done) return done;
    return tl::unexpected(without_folder(std::move(done.error()), scene->path.parent_path()));
  };
  return std::make_unique<FileStream>(FileStream::Read(read), offset, bytes);
}

}  // namespace

Response scenes_response(const RouteCall& call) {
  return list_response(call, ServedKind::scene);
}

Response scene_response(const RouteCall& call) {
  return json_response(call, scene_json(call.scene->name, call.scene->scene->facts));
}

Response scene_bootstrap_response(const RouteCall& call) {
  const std::shared_ptr<const ServedScene>& scene = call.scene->scene;
  const std::string etag = fmt::format("\"{}-bootstrap1\"", scene->facts.content);
  const uint64_t bytes = scene->bytes.first_bytes();
  const auto compress = [&](const std::string& hash) -> Compressor::Compressed {
    std::string body(static_cast<size_t>(bytes), '\0');
    // If this fails, so does the uncompressed response, which reports it.
    const auto read = scene->bytes.read(0, std::as_writable_bytes(std::span(body)));
    return read ? call.compressor.compress(body, hash) : nullptr;
  };
  return compressible_response(
      call, etag, CachePolicy::revalidated,
      {.type = "application/octet-stream",
       .bytes = bytes,
       .is_on_disk = true,
       .hash = [&] { return etag; },
       .compress = compress,
       .send = [&](Response& response) { response.stream = scene_stream(scene, 0, bytes); }});
}

Response scene_file_response(const RouteCall& call) {
  const std::shared_ptr<const ServedScene>& scene = call.scene->scene;
  const std::string etag = fmt::format("\"{}\"", scene->facts.content);
  Response response = begin_response(call.request, etag, CachePolicy::immutable, call.is_private);
  if (is_complete(response)) return response;
  const auto sent = begin_range(call.request, etag, scene->bytes.bytes(), response);
  if (!sent) return response;
  response.stream = scene_stream(scene, sent->first, sent->bytes);
  return response;
}

Response scene_thumbnail_response(const RouteCall& call) {
  const ServedScene& scene = *call.scene->scene;
  return picture_response(call, scene.path, scene.facts.content);
}

}  // namespace isosplat::server
