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

struct Content {
  const Request& request;
  std::shared_ptr<const StoreFile> store;
  const RouterLimits& limits;
};

void add_immutable_fields(Response& response, const std::string& etag) {
  response.set("ETag", etag);
  response.set("Cache-Control", "public, max-age=31536000, immutable");
}

Response bad_request(std::string_view message) {
  return error_response(400, status_name(Status::invalid_argument), message);
}

Response no_such_resource() {
  return error_response(404, status_name(Status::not_found),
                        "expected head, pages/{page}, chunks/{level}/{x}.{y}.{z}/{slab}, "
                        "chunks?isovalue=…, batch?chunks=… or file below the content id");
}

/// The answer that the request's conditions give without a body, if they do.
std::optional<Response> conditional_answer(const Request& request, const std::string& etag) {
  if (!request.if_match.empty() && !names_etag(request.if_match, etag, /*weak=*/false)) {
    return error_response(412, "precondition_failed",
                          "If-Match: the content has another ETag: ask without the condition");
  }
  if (!request.if_none_match.empty() && names_etag(request.if_none_match, etag, /*weak=*/true)) {
    Response response;
    response.status = 304;
    add_immutable_fields(response, etag);
    return response;
  }
  return std::nullopt;
}

Response immutable_bytes(std::vector<std::byte> bytes, const std::string& etag) {
  Response response;
  response.set("Content-Type", kBinary);
  add_immutable_fields(response, etag);
  auto owner = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  response.bytes = *owner;
  response.owner = std::move(owner);
  return response;
}

std::string etag_of(const StoreFile& store, std::string_view version = {}) {
  std::string etag = "\"" + store.content();
  if (!version.empty()) (etag += '-') += version;
  return etag += '"';
}

Response head_answer(const Content& content) {
  const std::string etag = etag_of(*content.store);
  if (auto early = conditional_answer(content.request, etag)) return std::move(*early);
  const std::span<const std::byte> head = content.store->head();
  return immutable_bytes({head.begin(), head.end()}, etag);
}

Response page_answer(const Content& content, std::string_view index) {
  const std::optional<uint32_t> page = parse_index(index);
  if (!page) return bad_request("page: expected a number");
  const std::string etag = etag_of(*content.store);
  if (*page < content.store->pages().size()) {
    if (auto early = conditional_answer(content.request, etag)) return std::move(*early);
  }
  Result<std::vector<std::byte>> bytes = content.store->read_page(*page);
  if (!bytes) return error_response(bytes.error());
  return immutable_bytes(std::move(*bytes), etag);
}

Response chunk_answer(const Content& content, std::span<const std::string> place) {
  const auto level = parse_index(place[0]);
  const auto block = parse_block(place[1]);
  const auto slab = parse_index(place[2]);
  if (!level || !block || !slab) {
    return bad_request(
        "chunk: expected chunks/{level}/{x}.{y}.{z}/{slab}, all decimal numbers "
        "without leading zeros");
  }
  const Result<ChunkRef> chunk = content.store->chunk({*level, *block}, *slab);
  if (!chunk) return error_response(chunk.error());
  const std::string etag = etag_of(*content.store);
  if (auto early = conditional_answer(content.request, etag)) return std::move(*early);
  std::vector<std::byte> bytes;
  if (Result<void> read = content.store->read_chunk(*chunk, bytes); !read) {
    return error_response(read.error());
  }
  return immutable_bytes(std::move(bytes), etag);
}

ChunkBudget budget_of(const RouterLimits& limits) {
  return {limits.query_bytes, limits.query_chunks, limits.query_directory_bytes};
}

Response frames_answer(const Content& content, ChunkSelection selection) {
  const RouterLimits& limits = content.limits;
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
  const std::string etag = etag_of(*content.store, kFrameVersion);
  if (auto early = conditional_answer(content.request, etag)) return std::move(*early);
  Response response;
  response.set("Content-Type", "application/vnd.isosplat.frames");
  response.set("X-Isosplat-Chunks", std::to_string(selection.count));
  add_immutable_fields(response, etag);
  response.stream = std::make_unique<FrameStream>(content.store, std::move(selection.chunks));
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

Response range_query_answer(const Content& content, const Target& target) {
  constexpr std::string_view kExpected =
      "chunks: expected isovalue=a..b (or one value) and level=L, and perhaps "
      "blocks=x.y.z,x.y.z,…, each once and nothing else";
  Parameters parameters(target);
  const auto isovalue = parameters.take("isovalue");
  const auto level_text = parameters.take("level");
  const auto block_list = parameters.take("blocks");
  if (!isovalue || !level_text || !parameters.complete()) return bad_request(kExpected);
  const auto range = parse_value_range(*isovalue);
  const auto level = parse_index(*level_text);
  if (!range) return bad_request("isovalue: expected a..b with a ≤ b, or one decimal number");
  if (!level) return bad_request("level: expected a number");

  const StoreFile& store = *content.store;
  const ValueMapping& mapping = store.info().mapping;
  float low = mapping.isocode(range->low);
  float high = mapping.isocode(range->high);
  if (low > high) std::swap(low, high);
  const ChunkBudget budget = budget_of(content.limits);
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
  return frames_answer(content, std::move(*selection));
}

Response batch_answer(const Content& content, const Target& target) {
  Parameters parameters(target);
  const auto list = parameters.take("chunks");
  if (!list || !parameters.complete()) {
    return bad_request("batch: expected chunks=level/x.y.z/slab,… once and nothing else");
  }
  const Result<std::vector<ChunkAddress>> addresses = parse_chunks(*list);
  if (!addresses) return bad_request("chunks: " + addresses.error().message);
  Result<ChunkSelection> selection =
      content.store->chunks_at(*addresses, budget_of(content.limits));
  if (!selection) return error_response(selection.error());
  return frames_answer(content, std::move(*selection));
}

Response file_answer(const Content& content) {
  const Request& request = content.request;
  const std::string etag = etag_of(*content.store);
  const uint64_t size = content.store->info().file_bytes;
  if (auto early = conditional_answer(request, etag)) return std::move(*early);
  if (Result<void> unchanged = content.store->check_unchanged(); !unchanged) {
    return error_response(unchanged.error());
  }
  RangeAnswer range;
  // Range is defined for GET only; a range of other content than the client holds is of no use.
  const bool applies = request.method == Method::get && !request.range.empty() &&
                       (request.if_range.empty() || request.if_range == etag);
  if (applies) range = parse_range(request.range, size);
  if (range.kind == RangeKind::unsatisfiable) {
    Response response = error_response(
        416, "range_not_satisfiable",
        "expected a range within " + std::to_string(size) + " bytes, found one beyond them");
    response.set("Content-Range", "bytes */" + std::to_string(size));
    response.set("Accept-Ranges", "bytes");
    return response;
  }
  Response response;
  response.set("Content-Type", kBinary);
  response.set("Accept-Ranges", "bytes");
  add_immutable_fields(response, etag);
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
  response.stream = std::make_unique<FileStream>(content.store, first, bytes);
  return response;
}

}  // namespace

Response content_answer(const Request& request, std::shared_ptr<const StoreFile> store,
                        std::span<const std::string> rest, const Target& target,
                        const RouterLimits& limits) {
  const Content content{request, std::move(store), limits};
  const std::string_view kind = rest.empty() ? std::string_view() : std::string_view(rest[0]);
  if (kind == "head" && rest.size() == 1) return head_answer(content);
  if (kind == "file" && rest.size() == 1) return file_answer(content);
  if (kind == "pages" && rest.size() == 2) return page_answer(content, rest[1]);
  if (kind == "chunks" && rest.size() == 4) return chunk_answer(content, rest.subspan(1));
  if (kind == "chunks" && rest.size() == 1) return range_query_answer(content, target);
  if (kind == "batch" && rest.size() == 1) return batch_answer(content, target);
  return no_such_resource();
}

}  // namespace isosplat
