#include "server/routes/content_routes.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "server/catalog/chunk_cache.h"
#include "server/catalog/thumbnail.h"
#include "server/http/conditions.h"
#include "server/http/streams.h"
#include "server/routes/byte_range.h"

namespace isosplat::server {
namespace {

/// Part of the ETags of responses in frames. Change it whenever the layout of frames changes.
constexpr std::string_view kFrameVersion = "frames1";

constexpr std::string_view kBinary = "application/octet-stream";

/// Adds a binary body to a response.
Response with_bytes(Response response, ChunkCache::Bytes bytes, std::string_view type = kBinary) {
  response.set("Content-Type", type);
  response.bytes = *bytes;
  response.owner = std::move(bytes);
  return response;
}

Response with_bytes(Response response, std::vector<std::byte> bytes,
                    std::string_view type = kBinary) {
  return with_bytes(std::move(response),
                    std::make_shared<const std::vector<std::byte>>(std::move(bytes)), type);
}

/// The verified bytes of a chunk, from a file that has not changed since it was opened. Errors:
/// those of StoreFile::read_chunk.
Result<ChunkCache::Bytes> read_chunk(const RouteCall& call, const ChunkRef& chunk) {
  const std::shared_ptr<const StoreFile>& store = call.volume->store;
  ChunkCache::Bytes kept = call.chunks.find(store, chunk.offset);
  if (kept && kept->size() == chunk.bytes) {
    if (Result<void> unchanged = store->check_unchanged(call.no_wait); !unchanged) {
      return tl::unexpected(unchanged.error());
    }
    return kept;
  }
  std::vector<std::byte> bytes;
  if (Result<void> read = store->read_chunk(chunk, bytes, call.no_wait); !read) {
    return tl::unexpected(read.error());
  }
  kept = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  call.chunks.add(store, chunk.offset, kept);
  return kept;
}

Response frames_response(const RouteCall& call, ChunkSelection selection) {
  const RouterLimits& limits = call.limits;
  if (selection.over_budget) {
    return error_response(
        413, "too_large",
        fmt::format("expected at most {} bytes of chunks, {} chunks and {} bytes of directory "
                    "pages, found at least {} bytes of chunks, {} chunks and {} bytes of directory "
                    "pages: request a narrower isovalue range, some of the blocks, or a coarser "
                    "level",
                    limits.query_bytes, limits.query_chunks, limits.query_directory_bytes,
                    selection.bytes, selection.count, selection.directory_bytes));
  }
  const std::shared_ptr<const StoreFile>& store = call.volume->store;
  Response response = begin_response(call.request, etag_of(*store, kFrameVersion),
                                     CachePolicy::immutable, call.is_private);
  if (is_complete(response)) return response;
  response.set("Content-Type", "application/vnd.isosplat.frames");
  response.set("X-Isosplat-Chunks", std::to_string(selection.count));
  response.stream = std::make_unique<FrameStream>(store, std::move(selection.chunks));
  return response;
}

}  // namespace

Response invalid_argument(std::string_view message) {
  return error_response(400, status_name(Status::invalid_argument), message);
}

std::string etag_of(const StoreFile& store, std::string_view version) {
  std::string etag = "\"" + store.content();
  if (!version.empty()) (etag += '-') += version;
  return etag += '"';
}

Response header_response(const RouteCall& call) {
  const StoreFile& store = *call.volume->store;
  Response response =
      begin_response(call.request, etag_of(store), CachePolicy::immutable, call.is_private);
  if (is_complete(response)) return response;
  const std::span<const std::byte> header = store.header();
  return with_bytes(std::move(response), {header.begin(), header.end()});
}

Response directory_page_response(const RouteCall& call) {
  const StoreFile& store = *call.volume->store;
  const std::optional<uint32_t> page = parse_index(call.arguments[2]);
  if (!page) return invalid_argument("page: expected a number");
  Response response =
      begin_response(call.request, etag_of(store), CachePolicy::immutable, call.is_private);
  if (*page < store.pages().size() && is_complete(response)) return response;
  Result<std::vector<std::byte>> bytes = store.read_page(*page, call.no_wait);
  if (!bytes) return error_response(bytes.error());
  return with_bytes(std::move(response), std::move(*bytes));
}

Response chunk_response(const RouteCall& call) {
  const StoreFile& store = *call.volume->store;
  const auto level = parse_index(call.arguments[2]);
  const auto block = parse_block(call.arguments[3]);
  const auto band = parse_index(call.arguments[4]);
  if (!level || !block || !band) {
    return invalid_argument(
        "chunk: expected chunks/{level}/{x}.{y}.{z}/{band}, all decimal numbers "
        "without leading zeros");
  }
  const Result<ChunkRef> chunk = store.chunk({*level, *block}, *band, call.no_wait);
  if (!chunk) return error_response(chunk.error());
  Response response =
      begin_response(call.request, etag_of(store), CachePolicy::immutable, call.is_private);
  if (is_complete(response)) return response;
  Result<ChunkCache::Bytes> bytes = read_chunk(call, *chunk);
  if (!bytes) return error_response(bytes.error());
  return with_bytes(std::move(response), std::move(*bytes));
}

Response chunks_response(const RouteCall& call) {
  const auto block_list = call.target.parameter("blocks");
  const auto range = parse_value_range(*call.target.parameter("isovalue"));
  const auto level = parse_index(*call.target.parameter("level"));
  if (!range) return invalid_argument("isovalue: expected a..b with a ≤ b, or one decimal number");
  if (!level) return invalid_argument("level: expected a number");

  const StoreFile& store = *call.volume->store;
  const ValueMapping& mapping = store.info().mapping;
  float low = mapping.quantized_isovalue(range->low);
  float high = mapping.quantized_isovalue(range->high);
  if (low > high) std::swap(low, high);
  const ChunkBudget budget = call.limits.chunk_budget();
  Result<ChunkSelection> selection = ChunkSelection{};
  if (block_list) {
    const Result<std::vector<Index3>> blocks = parse_blocks(*block_list);
    if (!blocks) return invalid_argument("blocks: " + blocks.error().message);
    std::vector<BlockKey> keys;
    keys.reserve(blocks->size());
    for (const Index3& index : *blocks) keys.push_back({*level, index});
    selection = store.chunks_for(keys, low, high, budget, call.no_wait);
  } else {
    selection = store.chunks_for(*level, low, high, budget, call.no_wait);
  }
  if (!selection) return error_response(selection.error());
  return frames_response(call, std::move(*selection));
}

Response batch_response(const RouteCall& call) {
  const Result<std::vector<ChunkAddress>> addresses =
      parse_chunks(*call.target.parameter("chunks"));
  if (!addresses) return invalid_argument("chunks: " + addresses.error().message);
  Result<ChunkSelection> selection =
      call.volume->store->chunks_at(*addresses, call.limits.chunk_budget(), call.no_wait);
  if (!selection) return error_response(selection.error());
  return frames_response(call, std::move(*selection));
}

Response file_response(const RouteCall& call) {
  const std::shared_ptr<const StoreFile>& store = call.volume->store;
  const std::string etag = etag_of(*store);
  const uint64_t size = store->info().file_bytes;
  Response response = begin_response(call.request, etag, CachePolicy::immutable, call.is_private);
  if (is_complete(response)) return response;
  if (Result<void> unchanged = store->check_unchanged(call.no_wait); !unchanged) {
    return error_response(unchanged.error());
  }
  const auto sent = begin_range(call.request, etag, size, response);
  if (!sent) return response;
  response.stream = std::make_unique<FileStream>(store, sent->first, sent->bytes);
  return response;
}

Response picture_response(const RouteCall& call, const std::filesystem::path& file,
                          const std::string& content) {
  if (call.no_wait) {
    call.no_wait->needs_disk = true;  // always: opening the file may wait for the disk as well
    return {};
  }
  auto picture = read_thumbnail(file, content);
  if (!picture) return error_response(picture.error());
  const std::string hash =
      etag_for({reinterpret_cast<const char*>(picture->data()), picture->size()});
  const std::string etag = fmt::format("\"{}-{}\"", content, hash.substr(1, hash.size() - 2));
  Response response = begin_response(call.request, etag, CachePolicy::revalidated, call.is_private);
  if (is_complete(response)) return response;
  return with_bytes(std::move(response), std::move(*picture), "image/webp");
}

Response thumbnail_response(const RouteCall& call) {
  const StoreFile& store = *call.volume->store;
  return picture_response(call, store.path(), store.content());
}

}  // namespace isosplat::server
