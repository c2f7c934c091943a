#include "server/content_routes.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "server/conditions.h"
#include "server/streams.h"

namespace isosplat {
namespace {

/// Part of the ETags of answers in frames: another frame layout needs another.
constexpr std::string_view kFrameVersion = "frames1";

constexpr std::string_view kBinary = "application/octet-stream";

Response bad_request(std::string_view message) {
  return error_response(400, status_name(Status::invalid_argument), message);
}

/// The answer that `begun` has begun, with a body.
Response with_bytes(Response begun, std::vector<std::byte> bytes) {
  begun.set("Content-Type", kBinary);
  auto owner = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  begun.bytes = *owner;
  begun.owner = std::move(owner);
  return begun;
}

std::string etag_of(const StoreFile& store, std::string_view version = {}) {
  std::string etag = "\"" + store.content();
  if (!version.empty()) (etag += '-') += version;
  return etag += '"';
}

ChunkBudget budget_of(const RouterLimits& limits) {
  return {limits.query_bytes, limits.query_chunks, limits.query_directory_bytes};
}

Response frames_answer(const RouteCall& call, ChunkSelection selection) {
  const RouterLimits& limits = call.limits;
  if (selection.over_budget) {
    return error_response(
        413, "too_large",
        "expected at most " + std::to_string(limits.query_bytes) + " bytes of at most " +
            std::to_string(limits.query_chunks) + " chunks, named in at most " +
            std::to_string(limits.query_directory_bytes) +
            " bytes of directory pages, found at least " + std::to_string(selection.bytes) +
            " bytes of " + std::to_string(selection.count) + " chunks in " +
            std::to_string(selection.directory_bytes) +
            " bytes of pages: ask for a narrower isovalue range, for some blocks, or a coarser "
            "level");
  }
  const std::shared_ptr<const StoreFile>& store = call.volume->store;
  Response response =
      begin_answer(call.request, etag_of(*store, kFrameVersion), CachePolicy::immutable);
  if (is_answered(response)) return response;
  response.set("Content-Type", "application/vnd.isosplat.frames");
  response.set("X-Isosplat-Chunks", std::to_string(selection.count));
  response.stream = std::make_unique<FrameStream>(store, std::move(selection.chunks));
  return response;
}

/// Looks a query's parameters up; each may occur once, and no others.
class Parameters {
 public:
  explicit Parameters(const Target& target) : target_(target) {}

  std::optional<std::string_view> take(std::string_view key) {
    std::optional<std::string_view> value;
    for (const auto& [name, text] : target_.query) {
      if (name != key) continue;
      repeated_ = repeated_ || value.has_value();
      value = text;
      ++taken_;
    }
    return value;
  }

  /// True when nothing is left over or was given twice.
  bool complete() const { return !repeated_ && taken_ == target_.query.size(); }

 private:
  const Target& target_;
  size_t taken_ = 0;
  bool repeated_ = false;
};

}  // namespace

Response header_answer(const RouteCall& call) {
  const StoreFile& store = *call.volume->store;
  Response response = begin_answer(call.request, etag_of(store), CachePolicy::immutable);
  if (is_answered(response)) return response;
  const std::span<const std::byte> header = store.header();
  return with_bytes(std::move(response), {header.begin(), header.end()});
}

Response directory_page_answer(const RouteCall& call) {
  const StoreFile& store = *call.volume->store;
  const std::optional<uint32_t> page = parse_index(call.arguments[2]);
  if (!page) return bad_request("page: expected a number");
  Response response = begin_answer(call.request, etag_of(store), CachePolicy::immutable);
  if (*page < store.pages().size() && is_answered(response)) return response;
  Result<std::vector<std::byte>> bytes = store.read_page(*page);
  if (!bytes) return error_response(bytes.error());
  return with_bytes(std::move(response), std::move(*bytes));
}

Response chunk_answer(const RouteCall& call) {
  const StoreFile& store = *call.volume->store;
  const auto level = parse_index(call.arguments[2]);
  const auto block = parse_block(call.arguments[3]);
  const auto band = parse_index(call.arguments[4]);
  if (!level || !block || !band) {
    return bad_request(
        "chunk: expected chunks/{level}/{x}.{y}.{z}/{band}, all decimal numbers "
        "without leading zeros");
  }
  const Result<ChunkRef> chunk = store.chunk({*level, *block}, *band);
  if (!chunk) return error_response(chunk.error());
  Response response = begin_answer(call.request, etag_of(store), CachePolicy::immutable);
  if (is_answered(response)) return response;
  std::vector<std::byte> bytes;
  if (Result<void> read = store.read_chunk(*chunk, bytes); !read) {
    return error_response(read.error());
  }
  return with_bytes(std::move(response), std::move(bytes));
}

Response chunks_answer(const RouteCall& call) {
  constexpr std::string_view kExpected =
      "chunks: expected isovalue=a..b (or one value) and level=L, and perhaps "
      "blocks=x.y.z,x.y.z,…, each once and nothing else";
  Parameters parameters(call.target);
  const auto isovalue = parameters.take("isovalue");
  const auto level_text = parameters.take("level");
  const auto block_list = parameters.take("blocks");
  if (!isovalue || !level_text || !parameters.complete()) return bad_request(kExpected);
  const auto range = parse_value_range(*isovalue);
  const auto level = parse_index(*level_text);
  if (!range) return bad_request("isovalue: expected a..b with a ≤ b, or one decimal number");
  if (!level) return bad_request("level: expected a number");

  const StoreFile& store = *call.volume->store;
  const ValueMapping& mapping = store.info().mapping;
  float low = mapping.quantized_isovalue(range->low);
  float high = mapping.quantized_isovalue(range->high);
  if (low > high) std::swap(low, high);
  const ChunkBudget budget = budget_of(call.limits);
  Result<ChunkSelection> selection = ChunkSelection{};
  if (block_list) {
    const Result<std::vector<Index3>> blocks = parse_blocks(*block_list);
    if (!blocks) return bad_request("blocks: " + blocks.error().message);
    std::vector<BlockKey> keys;
    keys.reserve(blocks->size());
    for (const Index3& index : *blocks) keys.push_back({*level, index});
    selection = store.chunks_for(keys, low, high, budget);
  } else {
    selection = store.chunks_for(*level, low, high, budget);
  }
  if (!selection) return error_response(selection.error());
  return frames_answer(call, std::move(*selection));
}

Response batch_answer(const RouteCall& call) {
  Parameters parameters(call.target);
  const auto list = parameters.take("chunks");
  if (!list || !parameters.complete()) {
    return bad_request("batch: expected chunks=level/x.y.z/band,… once and nothing else");
  }
  const Result<std::vector<ChunkAddress>> addresses = parse_chunks(*list);
  if (!addresses) return bad_request("chunks: " + addresses.error().message);
  Result<ChunkSelection> selection =
      call.volume->store->chunks_at(*addresses, budget_of(call.limits));
  if (!selection) return error_response(selection.error());
  return frames_answer(call, std::move(*selection));
}

Response file_answer(const RouteCall& call) {
  const std::shared_ptr<const StoreFile>& store = call.volume->store;
  const std::string etag = etag_of(*store);
  const uint64_t size = store->info().file_bytes;
  Response response = begin_answer(call.request, etag, CachePolicy::immutable);
  if (is_answered(response)) return response;
  if (Result<void> unchanged = store->check_unchanged(); !unchanged) {
    return error_response(unchanged.error());
  }
  const RangeAnswer range = requested_range(call.request, etag, size);
  if (range.kind == RangeKind::unsatisfiable) {
    response = error_response(
        416, "range_not_satisfiable",
        "expected a range within " + std::to_string(size) + " bytes, found one beyond them");
    response.set("Content-Range", "bytes */" + std::to_string(size));
    response.set("Accept-Ranges", "bytes");
    return response;
  }
  response.set("Content-Type", kBinary);
  response.set("Accept-Ranges", "bytes");
  uint64_t first = 0;
  uint64_t bytes = size;
  if (range.kind == RangeKind::part) {
    first = range.range.first;
    bytes = range.range.last - first + 1;
    response.status = 206;
    response.set("Content-Range", "bytes " + std::to_string(first) + "-" +
                                      std::to_string(range.range.last) + "/" +
                                      std::to_string(size));
  }
  response.stream = std::make_unique<FileStream>(store, first, bytes);
  return response;
}

}  // namespace isosplat
