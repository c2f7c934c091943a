#include <algorithm>

#include "shared/codec/chunk_codec.h"
#include "shared/codec/chunk_header.h"
#include "shared/codec/rans.h"
#include "shared/codec/residual_encoder.h"

namespace isosplat {
namespace {

/// Points that the predictor is fitted to, at most about twice so many.
constexpr uint32_t kFitSamples = 4096;

/// Chunks with fewer residuals than these merge 16, 8, 4, 2 levels.
constexpr uint32_t kMergeBelow[] = {64, 160, 400, 1000};

/// A header has fewer bits than this.
constexpr size_t kMostHeaderBits = 16384;

struct MaskEncoder {
  static constexpr bool kDecodes = false;
  const RansSymbol (*symbols)[16];
  RansEncoder& rans;

  uint32_t quad(uint32_t context, uint32_t value) {
    rans.put(symbols[context][value]);
    return value;
  }
  bool good() const { return true; }
};

}  // namespace

struct ChunkEncoder::Scratch {
  RansSymbol quad_symbols[256][16];

  CellMask mask;
  const PointPlane nothing = {};  // stands for the plane before the first
  PointPlane planes[kLatticeAcross];
  Row rows[kLatticeAcross][kLatticeAcross];  // by z, y
  Row first_row;                             // stands for the rows before the first
  Energies energies;
  PlanePoints points;
  // Of `points`:
  int32_t tap_sum[PlanePoints::kMost];
  int16_t value[PlanePoints::kMost];
  int16_t energy[PlanePoints::kMost];
  uint32_t folded[PlanePoints::kMost];
  PredictorFit fit;
  ResidualEncoder residuals;
  RansEncoder rans;
  BitWriter bit_writer;

  Scratch();
  uint32_t set_mask(const BlockView& block, uint32_t begin, uint32_t end);
  template <class F>
  void for_each_row(Index3 cells, int32_t z, const Row*& last, F f);
  void set_values(const BlockView& block, uint32_t point_count, ChunkHeader& header);
  void sample_row(int32_t y, int32_t z, const Neighbours& n, uint32_t stride, uint32_t& skip);
  void set_interval_shift(const BlockView& block, ChunkHeader& header) const;
  void add_intervals(const BlockView& block, const ChunkHeader& header, int32_t z,
                     int32_t& interval_energy);
  void set_residuals(const BlockView& block, const ChunkHeader& header);
  const PointPlane& before(int32_t z) const { return z > 0 ? planes[z - 1] : nothing; }
};

ChunkEncoder::Scratch::Scratch() : rows{}, first_row{} {
  const QuadSlots slots;
  for (int context = 0; context < 256; ++context) {
    for (int quad = 0; quad < 16; ++quad) {
      quad_symbols[context][quad] =
          RansSymbol(slots.start[context][quad], slots.frequency[context][quad], 12);
    }
  }
}

/// Returns the number of cells.
uint32_t ChunkEncoder::Scratch::set_mask(const BlockView& block, uint32_t begin, uint32_t end) {
  mask.clear();
  uint32_t count = 0;
  const CellInterval* intervals = block.intervals;
  for (int32_t z = 0; z < block.cells.z; ++z) {
    for (int32_t y = 0; y < block.cells.y; ++y, intervals += block.cells.x) {
      const uint64_t bits = VectorOps::active_cells(intervals, block.cells.x, begin, end);
      mask.row(y, z) = bits;
      count += static_cast<uint32_t>(__builtin_popcountll(bits));
    }
  }
  return count;
}

/// Calls f(y, neighbours) for each row of plane z that has points, in coding order. last: the row
/// coded before, to begin with first_row.
template <class F>
void ChunkEncoder::Scratch::for_each_row(Index3 cells, int32_t z, const Row*& last, F f) {
  for (int32_t y = 0; y <= cells.y; ++y) {
    if (!planes[z].points[y].any()) continue;
    const auto row_at = [&](int back, int32_t row_y) { return &rows[z - back][row_y]; };
    f(y, neighbours_of(planes[z], before(z), y, cells.y, row_at, last));
    last = &rows[z][y];
  }
}

/// Sets the rows' values, and fits the predictor to a sample of the points.
void ChunkEncoder::Scratch::set_values(const BlockView& block, uint32_t point_count,
                                       ChunkHeader& header) {
  const Index3 cells = block.cells;
  const uint32_t stride = std::max(1u, point_count / kFitSamples);
  uint32_t skip = stride / 2, all = 0;
  fit.clear();
  const Row* last = &first_row;
  for (int32_t z = 0; z <= cells.z; ++z) {
    for_each_row(cells, z, last, [&](int32_t y, const Neighbours& n) {
      fill_values(n, rows[z][y]);
      int16_t* const values = rows[z][y].value + kRowPad;
      const Code* voxels = block.voxels + (size_t(z) * (cells.y + 1) + y) * (cells.x + 1);
      const PointMask points_here = planes[z].points[y];
      for (int word = 0; word < 2; ++word) {
        for (uint64_t bits = points_here.word[word]; bits; bits &= bits - 1) {
          const int x = 64 * word + __builtin_ctzll(bits);
          values[x] = static_cast<int16_t>(voxels[x] ^ 0x8000);
          all |= voxels[x];
        }
      }
      pad_row(rows[z][y], cells.x);
      if (const uint32_t in_row = points_here.count(); skip >= in_row) {
        skip -= in_row;
      } else {
        sample_row(y, z, n, stride, skip);
      }
    });
  }
  header.wide = all > 255;
  const PredictorFit::Weights weights = fit.solve(stride);
  header.fitted = weights.fitted;
  std::copy_n(&weights.taps[0][0], kClasses * kTaps, &header.taps[0][0]);
}

/// Gives every stride-th point to the fit. skip: points to pass over first, here and on return.
void ChunkEncoder::Scratch::sample_row(int32_t y, int32_t z, const Neighbours& n, uint32_t stride,
                                       uint32_t& skip) {
  const int16_t* values = rows[z][y].value + kRowPad;
  for (int word = 0; word < 2; ++word) {
    const ClassBits classes = class_bits(planes[z], before(z), y, word);
    for (uint64_t bits = planes[z].points[y].word[word]; bits; bits &= bits - 1) {
      if (skip--) continue;
      skip = stride - 1;
      const int bit = __builtin_ctzll(bits), x = 64 * word + bit;
      fit.add(class_at(classes.words, bit), taps_at(n, x), values + x);
    }
  }
}

/// Finds how many low bits all the cells' intervals leave unused: zeros in min and ones in max.
void ChunkEncoder::Scratch::set_interval_shift(const BlockView& block, ChunkHeader& header) const {
  uint32_t used = 1u << kMaxIntervalShift;
  const CellInterval* intervals = block.intervals;
  for (int32_t z = 0; z < block.cells.z; ++z) {
    for (int32_t y = 0; y < block.cells.y; ++y, intervals += block.cells.x) {
      for (uint64_t bits = mask.row(y, z); bits; bits &= bits - 1) {
        const CellInterval interval = intervals[__builtin_ctzll(bits)];
        used |= interval.min | ~uint32_t{interval.max};
      }
    }
  }
  header.interval_shift = __builtin_ctz(used);
}

void ChunkEncoder::Scratch::add_intervals(const BlockView& block, const ChunkHeader& header,
                                          int32_t z, int32_t& interval_energy) {
  for (int32_t y = 0; y < block.cells.y; ++y) {
    const CellInterval* intervals =
        block.intervals + (size_t(z) * block.cells.y + y) * block.cells.x;
    for (uint64_t bits = mask.row(y, z); bits; bits &= bits - 1) {
      const int x = __builtin_ctzll(bits), at = kRowPad + x;
      const CellInterval range = header.shifted(corner_interval(
          ScalarOps::corners(rows[z][y].value + at, rows[z][y + 1].value + at,
                             rows[z + 1][y].value + at, rows[z + 1][y + 1].value + at)));
      const CellInterval interval = header.shifted(intervals[x]);
      const int32_t below = range.min - interval.min, beyond = interval.max - range.max;
      const int32_t octave = interval_octave(range, interval_energy);
      residuals.add(fold(below), residual_key(octave, kIntervalMin));
      residuals.add(fold(beyond), residual_key(octave, kIntervalMax));
      interval_energy = interval_energy_of(below, beyond);
    }
  }
}

void ChunkEncoder::Scratch::set_residuals(const BlockView& block, const ChunkHeader& header) {
  const Index3 cells = block.cells;
  Predictor predictor;
  predictor.set(header.taps, header.wide);
  energies.reset();
  const Row* last = &first_row;
  int32_t interval_energy = 0;
  for (int32_t z = 0; z <= cells.z; ++z) {
    points.set<VectorOps>(planes[z], before(z), energies, cells.y);
    for_each_row(cells, z, last, [&](int32_t y, const Neighbours& n) {
      const int16_t* const values = rows[z][y].value + kRowPad;
      for (int32_t i = points.first[y]; i < points.first[y + 1]; ++i) {
        const int32_t x = points.x[i];
        const ClassWeights& weights = predictor.classes[points.point_class[i]];
        tap_sum[i] = VectorOps::sum_taps(taps_at(n, x), weights.rows) +
                     weights.left * values[x - 1] + weights.left2 * values[x - 2];
        value[i] = values[x];
      }
    });
    // Apart from the sums, so that it becomes vector code.
    const int32_t in_plane = points.first[cells.y + 1];
    for (int32_t i = 0; i < in_plane; ++i) {
      const int32_t residual = value[i] - predictor.prediction(tap_sum[i]);
      folded[i] = fold(residual);
      energy[i] = Energies::energy_of(residual);
    }
    for (int32_t y = 0; y <= cells.y; ++y) {
      for (int32_t i = points.first[y]; i < points.first[y + 1]; ++i) {
        energies.values[y + 1][points.x[i] + 1] = energy[i];
        residuals.add(folded[i], points.key[i]);
      }
    }
    // The intervals of slice z − 1 come after the points of plane z.
    if (block.has_intervals && z > 0) add_intervals(block, header, z - 1, interval_energy);
  }
}

ChunkEncoder::ChunkEncoder() : scratch_(std::make_unique<Scratch>()) {}
ChunkEncoder::ChunkEncoder(ChunkEncoder&&) noexcept = default;
ChunkEncoder& ChunkEncoder::operator=(ChunkEncoder&&) noexcept = default;
ChunkEncoder::~ChunkEncoder() = default;

uint32_t ChunkEncoder::encode(const BlockView& block, uint32_t slab_begin, uint32_t slab_end,
                              std::vector<std::byte>& out) {
  Scratch& s = *scratch_;
  const uint32_t count = s.set_mask(block, slab_begin, slab_end);
  if (count == 0) return 0;

  uint32_t point_count = 0;
  for (int32_t z = 0; z <= block.cells.z; ++z) {
    point_count += s.planes[z].set(s.mask, block.cells, z);
  }
  const size_t most_residuals = point_count + (block.has_intervals ? 2 * size_t{count} : 0);
  s.residuals.begin(most_residuals);
  // At most a quad for each of the 2×2 cells of the grid, and as many again for bricks.
  s.rans.begin(most_residuals + kBlockCells * kBlockCells * kBlockCells / 2);
  s.bit_writer.begin(kMostHeaderBits + most_residuals * 32);

  BrickMask bricks = bricks_of(s.mask, block.cells);
  MaskEncoder mask_encoder{s.quad_symbols, s.rans};
  code_mask(block.cells, bricks, s.mask, mask_encoder);

  ChunkHeader header;
  set_first_row(slab_begin, slab_end, s.first_row);
  s.set_values(block, point_count, header);
  if (block.has_intervals) s.set_interval_shift(block, header);
  for (const uint32_t below : kMergeBelow) header.levels.merge += point_count < below;
  s.set_residuals(block, header);
  s.residuals.choose_models(header);

  write_header(header, block.has_intervals, s.bit_writer);
  s.residuals.put(header, s.rans, s.bit_writer);
  s.bit_writer.finish(out);
  s.rans.finish(out);
  return count;
}

}  // namespace isosplat
