#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/points/block_borders.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::server {

/// An axis-aligned box in the world: low ≤ position < high along each axis.
struct WorldBox {
  Vec3d low, high;

  bool contains(Vec3d at) const {
    return low.x <= at.x && low.y <= at.y && low.z <= at.z && at.x < high.x && at.y < high.y &&
           at.z < high.z;
  }
};

/// A query for points: which isosurface, and which part of it.
struct PointQuery {
  double isovalue = 0;
  uint32_t level = 0;
  std::optional<WorldBox> box;  ///< absent: all
  bool smooth_normals = true;   ///< false: the gradient of each cell
  bool values = false;          ///< whether PointArrays::values are needed
  /// The field whose values are needed (open_field); null: none.
  std::shared_ptr<const StoreFile> field = {};
};

/// Points, and the values of PointQuery::field there, if there is one; NaN: missing.
struct PointsWithField : PointArrays {
  std::vector<float> field;
};

/// Limits of the work and memory of one query.
struct PointLimits {
  ChunkBudget chunks;
  uint64_t cells = UINT64_MAX;         ///< of all chunks of the query
  uint64_t border_bytes = UINT64_MAX;  ///< for smooth normals
};

/// The points of an isosurface in a box, chunk by chunk, on the calling thread. They equal those of
/// `isosplat extract`, in raster order of blocks. Chunks are decoded twice. count_some() counts the
/// points, and for smooth normals computes the sums of gradients at the borders of blocks, which
/// stay in memory (16 bytes per lattice point that the surface touches there). next() computes the
/// points.
class SurfacePoints {
 public:
  struct Found {
    std::unique_ptr<SurfacePoints> points;
    std::string over_limit;  ///< the limit that is exceeded, in words; `points` is then null
  };

  /// Finds the chunks that are needed. Then call count_some() until is_counted(), and next() after
  /// that. Errors: those of StoreFile, not_found (no such level). With `no_wait`, also fails if it
  /// needs the disk, and reports this there.
  static Result<Found> find(std::shared_ptr<const StoreFile> store, const PointQuery& query,
                            const PointLimits& limits, NoWait* no_wait = nullptr);

  /// Counts the points of the next chunks: chunks of `cells` cells, and possibly one chunk more.
  /// Returns the limit that is exceeded, or an empty text. Requires !is_counted(). Errors: those of
  /// StoreFile and ChunkDecoder; as find() with `no_wait`, after which it can be called again.
  Result<std::string> count_some(uint64_t cells, NoWait* no_wait = nullptr);
  bool is_counted() const { return counted_ == parts_.size(); }

  /// Reads the next chunks that count_some() needs into the system's page cache: chunks of `bytes`
  /// bytes, and possibly one chunk more. Returns false after the last chunk, or if a chunk cannot
  /// be read; count_some() reports that error.
  bool fetch_some(uint64_t bytes);

  uint64_t count() const { return count_; }  ///< once all chunks are counted

  /// Cells of the largest chunk: next() returns at most this many points.
  uint32_t largest_chunk() const { return largest_chunk_; }

  /// The maximum bytes that fetch_next() keeps.
  uint64_t largest_chunk_bytes() const { return largest_chunk_bytes_; }

  /// Bytes of memory that this object uses, with the header and the directory pages of the field.
  uint64_t memory() const {
    if (!query_.field) return memory_;
    return memory_ + query_.field->header().size() + query_.field->directory_bytes();
  }

  /// Memory for decoding, smooth normals and a field: about 8 MB. For one thread; reused between
  /// calls.
  class Scratch;
  static std::shared_ptr<Scratch> make_scratch();

  bool is_at_end() const { return next_ == parts_.size(); }

  /// The points of the next chunk that has any. Requires is_counted() and !is_at_end(). Errors:
  /// those of count_some(); io_error if the file was changed in the meantime, or if `no_wait`
  /// reports that the chunk needs the disk. In the latter case, call again after fetch_next().
  Result<PointsWithField> next(Scratch& scratch, NoWait* no_wait = nullptr);

  /// Reads the next chunk, and keeps it for next(). Errors: those of StoreFile.
  Result<void> fetch_next();

 private:
  /// How much of a block is in the box. Blocks without points are needed for the smooth normals of
  /// their neighbours.
  enum class Inside : uint8_t { none, partly, whole };
  struct Part {
    ChunkRef chunk;
    Inside inside = Inside::whole;
    uint32_t points = 0;
    ChunkRef of_field = {};  ///< the chunk of the field
  };

  SurfacePoints(std::shared_ptr<const StoreFile> store, const PointQuery& query,
                const PointLimits& limits);
  Inside inside_of(BlockKey block) const;
  std::string add_chunks(ChunkSelection selection);
  Result<std::string> find_chunks(NoWait* no_wait);
  Result<std::string> find_field_chunks(const BlockRange& where, NoWait* no_wait);
  std::string over_budget(const ChunkSelection& selection, std::string_view of_field) const;
  Result<void> decode(const ChunkRef& chunk, Scratch& scratch, NoWait* no_wait) const;
  Result<void> decode_field(const Part& part, Scratch& scratch, NoWait* no_wait) const;
  PointsWithField points_in_box(const Part& part, Scratch& scratch, const BlockBorders* borders,
                                bool values) const;
  Result<std::string> count_part(size_t number, Scratch& scratch, NoWait* no_wait);
  void skip_empty_parts();

  std::shared_ptr<const StoreFile> store_;
  PointQuery query_;
  PointLimits limits_;
  float quantized_isovalue_;
  bool is_category_;         ///< the values of the query's field
  std::vector<Part> parts_;  ///< in raster order of blocks
  std::optional<BlockBorders> borders_;
  uint64_t border_bytes_ = 0;
  size_t ahead_ = 0;    ///< number of parts that fetch_some() has read
  size_t counted_ = 0;  ///< number of parts that are counted
  size_t next_ = 0;
  uint64_t count_ = 0;
  uint64_t memory_ = 0;
  uint32_t largest_chunk_ = 0;
  uint64_t largest_chunk_bytes_ = 0;
  std::vector<std::byte> fetched_;  ///< the chunk for next(); empty: it is not fetched
  std::vector<std::byte> fetched_of_field_;
};

}  // namespace isosplat::server
