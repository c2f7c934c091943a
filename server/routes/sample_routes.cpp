#include "server/routes/sample_routes.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "server/catalog/volume_json.h"
#include "server/http/conditions.h"
#include "server/http/streams.h"
#include "server/routes/content_routes.h"
#include "server/routes/json_response.h"
#include "server/routes/point_records.h"
#include "server/routes/surface_points.h"
#include "shared/core/points/position_precision.h"
#include "shared/system/store_file/field_file.h"

namespace isosplat::server {
namespace {

/// Part of the ETags. Change it whenever the same request gets other bytes.
constexpr std::string_view kSamplesVersion = "samples1";
constexpr std::string_view kIsovaluesVersion = "isovalues1";

/// The most bytes of directory pages of a field that a response keeps in memory. A larger page is
/// kept alone.
constexpr uint64_t kFieldDirectoryBytes = uint64_t{4} << 20;

/// Points as records, optionally after the header of a .npy file. Computes at least one chunk at a
/// time.
class SampleStream final : public BodyStream {
 public:
  SampleStream(std::unique_ptr<SurfacePoints> points, PointRecords records, std::string header)
      : points_(std::move(points)), records_(std::move(records)), header_(std::move(header)) {
    records_left_ = points_->count();
    size_ = header_.size() + records_left_ * records_.bytes();
  }

  uint64_t size() const override { return size_; }

  uint64_t memory() const override {
    return points_->memory() + points_->largest_chunk_bytes() + kComputedBytes +
           uint64_t{points_->largest_chunk()} * records_.bytes();
  }

  Step next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) override {
    const auto scratch = SurfacePoints::make_scratch();
    while (!points_->is_at_end() && out.size() < kComputedBytes) {
      const Result<PointsWithField> points = points_->next(*scratch, no_wait);
      if (!points) {
        if (no_wait && no_wait->needs_disk) return Step::more;
        error = points.error();
        return Step::broken;
      }
      if (points->positions.size() > records_left_) return changed(error);
      records_left_ -= points->positions.size();
      append_header(out);
      records_.append(*points, points->field, out);
    }
    if (!points_->is_at_end()) return Step::more;
    append_header(out);
    return records_left_ == 0 ? Step::last : changed(error);
  }

  Result<void> fetch() override { return points_->fetch_next(); }

 private:
  /// Size of the pieces: larger than those of other streams, since each piece switches to another
  /// thread.
  static constexpr size_t kComputedBytes = 512 * 1024;

  void append_header(std::vector<std::byte>& out) {
    const auto text = std::as_bytes(std::span(header_));
    out.insert(out.end(), text.begin(), text.end());
    header_.clear();
  }

  static Step changed(Error& error) {
    error = {Status::io_error, "a store was changed while its points were computed"};
    return Step::broken;
  }

  std::unique_ptr<SurfacePoints> points_;
  PointRecords records_;
  std::string header_;
  uint64_t records_left_ = 0;
  uint64_t size_ = 0;
};

/// "v", "v,v,…", or "a..b" as `steps` evenly spaced values with both ends. Errors:
/// invalid_argument.
Result<std::vector<double>> parse_isovalues(std::string_view text,
                                            std::optional<std::string_view> steps, uint32_t most) {
  const auto invalid = [](std::string message) {
    return fail(Status::invalid_argument, std::move(message));
  };
  std::vector<double> isovalues;
  if (text.find("..") == std::string_view::npos) {
    if (steps) return invalid("steps: expected only with isovalue=a..b");
    while (true) {
      const auto value = parse_value(text.substr(0, text.find(',')));
      if (!value || isovalues.size() == most) {
        return invalid(fmt::format("isovalue: expected a..b, or 1 to {} decimal numbers", most));
      }
      isovalues.push_back(*value);
      const size_t comma = text.find(',');
      if (comma == std::string_view::npos) return isovalues;
      text.remove_prefix(comma + 1);
    }
  }
  const auto range = parse_value_range(text);
  const auto count = parse_index(steps.value_or("64"), most);
  if (!range) return invalid("isovalue: expected a..b with a ≤ b, or decimal numbers");
  if (!count || *count < 2) return invalid(fmt::format("steps: expected 2 to {}", most));
  for (uint32_t i = 0; i < *count; ++i) {
    const double part = static_cast<double>(i) / (*count - 1);
    isovalues.push_back(range->low * (1 - part) + range->high * part);
  }
  return isovalues;
}

Result<WorldBox> parse_world_box(std::string_view text) {
  const auto box = parse_box(text);
  if (!box || !((*box)[0] <= (*box)[3] && (*box)[1] <= (*box)[4] && (*box)[2] <= (*box)[5])) {
    return fail(Status::invalid_argument,
                "box: expected x0,y0,z0,x1,y1,z1 in the volume's units, with x0 ≤ x1, y0 ≤ y1 and "
                "z0 ≤ z1");
  }
  return WorldBox{{(*box)[0], (*box)[1], (*box)[2]}, {(*box)[3], (*box)[4], (*box)[5]}};
}

struct SampleRequest {
  PointQuery query;
  PointRecords records;
  std::optional<size_t> field;  ///< index of the field of the store
  bool npy = true;
};

Result<SampleRequest> parse_request(const Target& target, const StoreInfo& info) {
  const auto level = target.parameter("level");
  const auto box = target.parameter("box");
  const auto fields = target.parameter("fields");
  const auto shading = target.parameter("shading");
  const auto format = target.parameter("format");
  const auto invalid = [](std::string message) {
    return fail(Status::invalid_argument, std::move(message));
  };
  SampleRequest request;
  const auto value = parse_value(*target.parameter("isovalue"));
  if (!value) return invalid("isovalue: expected a decimal number");
  request.query.isovalue = *value;
  const auto level_number = parse_index(level.value_or("0"));
  if (!level_number) return invalid("level: expected a number");
  request.query.level = *level_number;
  if (box) {
    auto parsed = parse_world_box(*box);
    if (!parsed) return tl::unexpected(parsed.error());
    request.query.box = *parsed;
  }
  auto records =
      PointRecords::parse(fields.value_or("positions,normals"), needs_doubles(info.grid));
  if (!records) return invalid("fields: " + records.error().message);
  request.records = std::move(*records);
  if (const auto name = target.parameter("field")) {
    const auto found = find_field(info, std::string(*name));
    if (!found) return tl::unexpected(found.error());
    request.field = *found;
    request.records.add_field(info.fields[*found].info.name);
  }
  if (shading && *shading != "smooth" && *shading != "exact") {
    return invalid("shading: expected smooth or exact");
  }
  // Only smooth normals need the borders of blocks.
  request.query.smooth_normals = shading != "exact" && request.records.has(PointField::normals);
  request.query.values = request.records.has(PointField::values);
  if (format && *format != "npy" && *format != "raw") {
    return invalid("format: expected npy or raw");
  }
  request.npy = format != "raw";
  return request;
}

/// Points that are being counted, in several turns.
struct SampleProgress final : WorkTurn::Progress {
  explicit SampleProgress(std::unique_ptr<SurfacePoints> counted) : points(std::move(counted)) {}
  std::unique_ptr<SurfacePoints> points;
};

Response points_too_large(const std::string& over_limit) {
  return error_response(413, "too_large", over_limit + ": request a box, or a coarser level");
}

}  // namespace

Response isovalues_response(const RouteCall& call) {
  const Target& target = call.target;
  const auto level = parse_index(target.parameter("level").value_or("0"));
  if (!level) return invalid_argument("level: expected a number");
  const auto isovalues = parse_isovalues(*target.parameter("isovalue"), target.parameter("steps"),
                                         call.limits.query_isovalues);
  if (!isovalues) return error_response(isovalues.error());
  const StoreFile& store = *call.volume->store;
  const ValueMapping& mapping = store.info().mapping;
  const auto [low, high] = std::ranges::minmax(*isovalues);
  ChunkBudget budget = call.limits.chunk_budget();
  budget.bytes = UINT64_MAX;  // no limit, since none of them are read
  const auto selection = store.chunks_for(*level, mapping.quantized_isovalue(low),
                                          mapping.quantized_isovalue(high), budget, call.no_wait);
  if (!selection) return error_response(selection.error());
  if (selection->over_budget) {
    return error_response(
        413, "too_large",
        fmt::format("expected at most {} chunks and {} bytes of directory pages, found at least {} "
                    "and {}: request a narrower range, or a coarser level",
                    budget.chunks, budget.directory_bytes, selection->count,
                    selection->directory_bytes));
  }
  return json_response(
      call,
      isovalues_json(store.info(), *level, isovalue_needs(*isovalues, mapping, selection->chunks)),
      etag_of(store, kIsovaluesVersion), CachePolicy::immutable);
}

Response samples_response(const RouteCall& call) {
  const std::shared_ptr<const StoreFile>& store = call.volume->store;
  auto request = parse_request(call.target, store->info());
  if (!request) return error_response(request.error());
  if (request->query.level >= store->info().levels) {
    return error_response(404, status_name(Status::not_found),
                          fmt::format("level: expected a number below {}, found {}",
                                      store->info().levels, request->query.level));
  }
  Response response = begin_response(call.request, etag_of(*store, kSamplesVersion),
                                     CachePolicy::immutable, call.is_private);
  if (is_complete(response)) return response;
  if (call.thread == ThreadKind::connection) {
    call.no_wait->needs_disk = true;
    return response;
  }
  std::unique_ptr<WorkTurn::Progress> own;
  std::unique_ptr<WorkTurn::Progress>& progress = call.turn ? call.turn->progress : own;
  if (!progress) {
    if (request->field) {
      // Its header is read from the disk.
      if (call.no_wait) {
        call.no_wait->needs_disk = true;
        return response;
      }
      auto field = open_field(*store, *request->field, kFieldDirectoryBytes);
      if (!field) {
        // The message has the path of the store.
        const std::string& name = store->info().fields[*request->field].info.name;
        return error_response({field.error().status,
                               fmt::format("field '{}': expected a valid field in {}, found damage",
                                           name, store->path().filename().string())});
      }
      request->query.field = std::move(*field);
    }
    const PointLimits limits{call.limits.chunk_budget(), call.limits.query_cells,
                             call.limits.query_border_bytes};
    auto found = SurfacePoints::find(store, request->query, limits, call.no_wait);
    if (!found) return error_response(found.error());
    if (!found->points) return points_too_large(found->over_limit);
    progress = std::make_unique<SampleProgress>(std::move(found->points));
  }
  std::unique_ptr<SurfacePoints>& points = static_cast<SampleProgress&>(*progress).points;
  if (call.thread == ThreadKind::disk) {
    const bool is_unfinished = points->fetch_some(call.turn ? kBytesPerTurn : UINT64_MAX);
    if (call.turn) call.turn->is_unfinished = is_unfinished;
    return response;
  }
  if (!points->is_counted()) {
    const auto over = points->count_some(call.turn ? kCellsPerTurn : UINT64_MAX, call.no_wait);
    if (!over) return error_response(over.error());
    if (!over->empty()) return points_too_large(*over);
    if (!points->is_counted()) {
      call.turn->is_unfinished = true;
      return response;
    }
  }
  const uint64_t count = points->count();
  response.set("Content-Type", "application/octet-stream");
  response.set("X-Isosplat-Dtype", request->records.dtype());
  response.set("X-Isosplat-Points", std::to_string(count));
  std::string header = request->npy ? request->records.npy_header(count) : std::string();
  response.stream = std::make_unique<SampleStream>(std::move(points), std::move(request->records),
                                                   std::move(header));
  return response;
}

}  // namespace isosplat::server
