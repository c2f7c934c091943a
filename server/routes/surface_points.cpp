#include "server/routes/surface_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "shared/core/categories/categories.h"
#include "shared/core/points/chunk_shape.h"
#include "shared/core/points/field_lattice.h"

namespace isosplat::server {

class SurfacePoints::Scratch {
 public:
  ChunkDecoder decoder;
  DecodedCells cells;
  std::vector<std::byte> bytes;
  LatticeGradients gradients;
  std::vector<std::byte> field_bytes;
  std::vector<CellCorners> field_corners;
  std::optional<FieldLattice> field;  ///< of the chunk that was decoded last
};

namespace {

/// Enlarges blocks by this fraction of a cell, so that rounding does not place a point outside of
/// its block.
constexpr double kMarginCells = 0.25;

/// Transforms the corners of a box, and returns their bounding box.
template <class Transform>
WorldBox box_around(const WorldBox& box, const Transform& transform) {
  WorldBox result{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at =
        transform(Vec3d{corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                        corner & 4 ? box.high.z : box.low.z});
    result.low = {std::min(result.low.x, at.x), std::min(result.low.y, at.y),
                  std::min(result.low.z, at.z)};
    result.high = {std::max(result.high.x, at.x), std::max(result.high.y, at.y),
                   std::max(result.high.z, at.z)};
  }
  return result;
}

/// The indices of the blocks from `low` to `high` (in blocks), and one more at each end, of `count`
/// blocks along an axis. If coordinates overflow, returns all blocks.
std::pair<int32_t, int32_t> blocks_between(double low, double high, int32_t count) {
  const double first = std::floor(low) - 1, end = std::floor(high) + 2;
  return {first > 0 ? static_cast<int32_t>(std::min<double>(first, count)) : 0,
          end < count ? static_cast<int32_t>(std::max(end, 0.0)) : count};
}

/// The blocks that intersect a box, and their neighbours.
BlockRange blocks_around(const WorldBox& box, const VolumeGrid& grid, uint32_t level) {
  const double block_voxels = std::ldexp(kBlockCells, static_cast<int>(level));
  const Matrix3d dual = grid.dual_edges();
  const WorldBox in_blocks = box_around(box, [&](Vec3d at) {
    return multiply_transposed(dual, at - grid.origin) * (1 / block_voxels);
  });
  const Index3 count = level_grid(grid.voxels, level).blocks;
  const auto x = blocks_between(in_blocks.low.x, in_blocks.high.x, count.x);
  const auto y = blocks_between(in_blocks.low.y, in_blocks.high.y, count.y);
  const auto z = blocks_between(in_blocks.low.z, in_blocks.high.z, count.z);
  return {{x.first, y.first, z.first}, {x.second, y.second, z.second}};
}

/// Orders the chunks of a level: blocks in raster order, and their bands.
std::tuple<int32_t, int32_t, int32_t, uint32_t> place_of(const ChunkRef& chunk) {
  const Index3 at = chunk.block.index;
  return {at.z, at.y, at.x, chunk.band};
}

}  // namespace

std::shared_ptr<SurfacePoints::Scratch> SurfacePoints::make_scratch() {
  return std::make_shared<Scratch>();
}

SurfacePoints::SurfacePoints(std::shared_ptr<const StoreFile> store, const PointQuery& query,
                             const PointLimits& limits)
    : store_(std::move(store)),
      query_(query),
      limits_(limits),
      quantized_isovalue_(store_->info().mapping.quantized_isovalue(query.isovalue)),
      is_category_(query.field && !categories_of(query.field->info().metadata).empty()) {}

Result<SurfacePoints::Found> SurfacePoints::find(std::shared_ptr<const StoreFile> store,
                                                 const PointQuery& query, const PointLimits& limits,
                                                 NoWait* no_wait) {
  std::unique_ptr<SurfacePoints> points(new SurfacePoints(std::move(store), query, limits));
  Result<std::string> over = points->find_chunks(no_wait);
  if (!over) return tl::unexpected(std::move(over.error()));
  if (!over->empty()) return Found{nullptr, std::move(*over)};
  return Found{std::move(points), {}};
}

bool SurfacePoints::fetch_some(uint64_t bytes) {
  std::vector<std::byte> chunk;
  for (uint64_t read = 0; ahead_ < parts_.size() && read < bytes; read += chunk.size()) {
    chunk.clear();
    if (!store_->read_chunk(parts_[ahead_++].chunk, chunk)) return false;
  }
  return ahead_ < parts_.size();
}

/// Returns the limit that is exceeded, or an empty text.
Result<std::string> SurfacePoints::find_chunks(NoWait* no_wait) {
  BlockRange where;
  if (query_.box && query_.level < store_->info().levels) {
    where = blocks_around(*query_.box, store_->info().grid, query_.level);
  }
  auto selection = store_->chunks_for(query_.level, quantized_isovalue_, quantized_isovalue_,
                                      limits_.chunks, no_wait, where);
  if (!selection) return tl::unexpected(std::move(selection.error()));
  if (std::string over = add_chunks(std::move(*selection)); !over.empty()) return over;
  return query_.field ? find_field_chunks(where, no_wait) : std::string();
}

/// Finds the chunks of the field by the query that has found those of the store: the pages, blocks
/// and bands are the same. Returns the limit that is exceeded, or an empty text.
Result<std::string> SurfacePoints::find_field_chunks(const BlockRange& where, NoWait* no_wait) {
  if (parts_.empty()) return std::string();
  const StoreFile& field = *query_.field;
  auto selection = field.chunks_for(query_.level, quantized_isovalue_, quantized_isovalue_,
                                    limits_.chunks, no_wait, where);
  if (!selection) return tl::unexpected(std::move(selection.error()));
  if (selection->over_budget) {
    return over_budget(*selection, fmt::format(" of the field '{}'", field.info().field->name));
  }
  std::ranges::sort(selection->chunks, {}, place_of);
  uint64_t largest = 0;
  auto found = selection->chunks.begin();
  for (Part& part : parts_) {
    const auto place = place_of(part.chunk);
    while (found != selection->chunks.end() && place_of(*found) < place) ++found;
    if (found == selection->chunks.end() || place_of(*found) != place) {
      return fail(Status::malformed_page,
                  fmt::format("{}: expected chunk {}, as the store has, found none: rebuild the "
                              "store",
                              field.path().filename().string(),
                              chunk_name(part.chunk.block, part.chunk.band)));
    }
    part.of_field = *found;
    largest = std::max<uint64_t>(largest, found->bytes);
  }
  largest_chunk_bytes_ += largest;
  return std::string();
}

/// The limits of one query, in words. of_field: empty, or " of the field …".
std::string SurfacePoints::over_budget(const ChunkSelection& selection,
                                       std::string_view of_field) const {
  return fmt::format(
      "expected at most {} bytes of chunks, {} chunks and {} bytes of directory pages{}, found at "
      "least {}, {} and {}",
      limits_.chunks.bytes, limits_.chunks.chunks, limits_.chunks.directory_bytes, of_field,
      selection.bytes, selection.count, selection.directory_bytes);
}

SurfacePoints::Inside SurfacePoints::inside_of(BlockKey block) const {
  if (!query_.box) return Inside::whole;
  const VolumeGrid& grid = store_->info().grid;
  const Index3 cells = block_cells(level_grid(grid.voxels, block.level), block.index);
  const double cell = std::ldexp(1.0, static_cast<int>(block.level));
  const Vec3d margin{kMarginCells, kMarginCells, kMarginCells};
  const Vec3d first{double(block.index.x) * kBlockCells, double(block.index.y) * kBlockCells,
                    double(block.index.z) * kBlockCells};
  const Vec3d end = first + Vec3d{double(cells.x), double(cells.y), double(cells.z)};
  const WorldBox hull = box_around({(first - margin) * cell, (end + margin) * cell},
                                   [&](Vec3d index) { return grid.world(index); });
  const WorldBox& box = *query_.box;
  const bool meets = hull.low.x < box.high.x && hull.low.y < box.high.y &&
                     hull.low.z < box.high.z && box.low.x <= hull.high.x &&
                     box.low.y <= hull.high.y && box.low.z <= hull.high.z;
  if (!meets) return Inside::none;
  return box.contains(hull.low) && box.contains(hull.high) ? Inside::whole : Inside::partly;
}

/// Adds the chunks that are needed, in raster order. Returns the limit that is exceeded.
std::string SurfacePoints::add_chunks(ChunkSelection selection) {
  if (selection.over_budget) return over_budget(selection, {});
  uint64_t cells = 0;
  bool has_points = false;
  for (const ChunkRef& chunk : selection.chunks) {
    if (chunk.cells == 0) continue;
    const Inside inside = inside_of(chunk.block);
    if (inside == Inside::none && !query_.smooth_normals) continue;
    has_points = has_points || inside != Inside::none;
    cells += chunk.cells;
    largest_chunk_ = std::max(largest_chunk_, chunk.cells);
    largest_chunk_bytes_ = std::max<uint64_t>(largest_chunk_bytes_, chunk.bytes);
    parts_.push_back({chunk, inside, 0});
  }
  if (!has_points) parts_.clear();
  if (has_points && cells > limits_.cells) {
    return fmt::format("expected chunks with at most {} cells, found {}", limits_.cells, cells);
  }
  std::ranges::sort(parts_, {}, [](const Part& part) { return place_of(part.chunk); });
  memory_ = parts_.capacity() * sizeof(Part);
  if (query_.smooth_normals) {
    std::vector<Index3> blocks;
    for (const Part& part : parts_) blocks.push_back(part.chunk.block.index);
    borders_.emplace(std::move(blocks));
  }
  return {};
}

Result<std::string> SurfacePoints::count_some(uint64_t cells, NoWait* no_wait) {
  const auto scratch = make_scratch();
  for (uint64_t decoded = 0; !is_counted() && decoded < cells;) {
    decoded += parts_[counted_].chunk.cells;
    Result<std::string> over = count_part(counted_, *scratch, no_wait);
    if (!over || !over->empty()) return over;
    ++counted_;
  }
  if (!is_counted()) return std::string();
  memory_ += border_bytes_;
  skip_empty_parts();
  return std::string();
}

/// Counts the points of a chunk, and computes its borders. Returns the limit that is exceeded.
Result<std::string> SurfacePoints::count_part(size_t number, Scratch& scratch, NoWait* no_wait) {
  Part& part = parts_[number];
  if (auto decoded = decode(part.chunk, scratch, no_wait); !decoded) {
    return tl::unexpected(std::move(decoded.error()));
  }
  if (part.inside == Inside::whole) {
    // One point for each active cell.
    part.points = static_cast<uint32_t>(std::ranges::count_if(
        scratch.cells.interval,
        [&](const CellInterval& interval) { return is_active(interval, quantized_isovalue_); }));
  } else if (part.inside == Inside::partly) {
    part.points =
        static_cast<uint32_t>(points_in_box(part, scratch, nullptr, false).positions.size());
  }
  count_ += part.points;
  if (!borders_) return std::string();
  borders_->set(number, scratch.gradients.border_of(scratch.cells));
  border_bytes_ += borders_->memory(number);
  if (border_bytes_ <= limits_.border_bytes) return std::string();
  return fmt::format(
      "expected at most {} bytes of gradients at the borders of blocks, found more (none are "
      "needed with shading=exact)",
      limits_.border_bytes);
}

Result<void> SurfacePoints::decode(const ChunkRef& chunk, Scratch& scratch, NoWait* no_wait) const {
  std::span<const std::byte> bytes = fetched_;
  if (bytes.empty()) {
    scratch.bytes.clear();
    if (auto read = store_->read_chunk(chunk, scratch.bytes, no_wait); !read) return read;
    bytes = scratch.bytes;
  }
  auto decoded = scratch.decoder.decode(bytes, shape_of(store_->info(), chunk), scratch.cells);
  if (!decoded) {
    decoded.error().message =
        fmt::format("{}: chunk {}: {}", store_->path().filename().string(),
                    chunk_name(chunk.block, chunk.band), decoded.error().message);
  }
  return decoded;
}

/// Reads the chunk of the field. The chunk of the store must be decoded.
Result<void> SurfacePoints::decode_field(const Part& part, Scratch& scratch,
                                         NoWait* no_wait) const {
  const StoreFile& field = *query_.field;
  const ValueMapping& mapping = field.info().field->mapping;
  std::span<const std::byte> bytes = fetched_of_field_;
  if (bytes.empty()) {
    scratch.field_bytes.clear();
    auto read = field.read_chunk(part.of_field, scratch.field_bytes, no_wait);
    if (!read) return read;
    bytes = scratch.field_bytes;
  }
  auto decoded =
      scratch.decoder.decode_field(bytes, shape_of(store_->info(), part.chunk).block_cells,
                                   scratch.cells.cell, 1u << mapping.bits, scratch.field_corners);
  if (!decoded) {
    decoded.error().message =
        fmt::format("{}: chunk {}: {}", field.path().filename().string(),
                    chunk_name(part.chunk.block, part.chunk.band), decoded.error().message);
    return decoded;
  }
  if (!scratch.field) scratch.field.emplace(mapping, is_category_);
  scratch.field->set(scratch.cells.cell, scratch.field_corners);
  return {};
}

/// The points of the decoded chunk that are in the box. `borders`: null for the gradients of cells.
PointsWithField SurfacePoints::points_in_box(const Part& part, Scratch& scratch,
                                             const BlockBorders* borders, bool values) const {
  const ChunkFrame frame{&store_->info().grid, &store_->info().mapping, part.chunk.block};
  ProjectionOptions options;
  options.values = values;
  std::vector<PointPlace> found;
  std::vector<PointPlace>* const places = scratch.field ? &found : nullptr;
  PointsWithField points{borders ? borders->project(scratch.cells, frame, quantized_isovalue_,
                                                    options, scratch.gradients, places)
                                 : project_samples(scratch.cells, frame, quantized_isovalue_,
                                                   options, nullptr, places),
                         {}};
  for (const PointPlace& at : found) points.field.push_back(scratch.field->at(at.cell, at.in_cell));
  if (part.inside == Inside::whole) return points;
  size_t kept = 0;
  for (size_t i = 0; i < points.positions.size(); ++i) {
    if (!query_.box->contains(points.positions[i])) continue;
    points.positions[kept] = points.positions[i];
    points.normals[kept] = points.normals[i];
    if (values) points.values[kept] = points.values[i];
    if (places) points.field[kept] = points.field[i];
    ++kept;
  }
  points.positions.resize(kept);
  points.normals.resize(kept);
  if (values) points.values.resize(kept);
  if (places) points.field.resize(kept);
  return points;
}

void SurfacePoints::skip_empty_parts() {
  while (next_ < parts_.size() && parts_[next_].points == 0) ++next_;
}

Result<void> SurfacePoints::fetch_next() {
  fetched_.clear();
  fetched_of_field_.clear();
  auto read = store_->read_chunk(parts_[next_].chunk, fetched_);
  if (!read || !query_.field) return read;
  return query_.field->read_chunk(parts_[next_].of_field, fetched_of_field_);
}

Result<PointsWithField> SurfacePoints::next(Scratch& scratch, NoWait* no_wait) {
  const Part& part = parts_[next_];
  if (auto decoded = decode(part.chunk, scratch, no_wait); !decoded) {
    return tl::unexpected(std::move(decoded.error()));
  }
  if (query_.field) {
    auto decoded = decode_field(part, scratch, no_wait);
    if (!decoded) return tl::unexpected(std::move(decoded.error()));
  }
  fetched_.clear();
  fetched_of_field_.clear();
  ++next_;
  skip_empty_parts();
  return points_in_box(part, scratch, borders_ ? &*borders_ : nullptr, query_.values);
}

}  // namespace isosplat::server
