#include <algorithm>

#include "shared/core/codec/band_masks.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/codec/chunk_header.h"
#include "shared/core/codec/plane_residuals.h"
#include "shared/core/codec/rans.h"
#include "shared/core/codec/residual_encoder.h"

namespace isosplat {
namespace {

/// The predictor is fitted to a sample of kFitSamples to 2 · kFitSamples points, or to all points
/// of a chunk that has fewer.
constexpr uint32_t kFitSamples = 4096;

/// Chunks with fewer residuals than these merge 16, 8, 4, 2 levels.
constexpr uint32_t kMergeBelow[] = {64, 160, 400, 1000};

/// A header has fewer bits than this.
constexpr size_t kMaxHeaderBits = 16384;

constexpr uint32_t kQuadBits = 12;
static_assert(kQuadTotal == 1u << kQuadBits);

static_assert(PlaneResiduals::kSlack <= ResidualEncoder::kSlack);

/// One quad per 2×2 cells makes a quarter of the number of cells; the quads of bricks are fewer.
constexpr size_t kMaxQuads = kBlockCells * kBlockCells * kBlockCells / 2;

/// Collects the mask's symbols, which are encoded last.
struct MaskEncoder {
  static constexpr bool kDecodes = false;
  uint16_t* to;

  uint32_t quad(uint32_t context, uint32_t value) {
    *to++ = static_cast<uint16_t>(context * 16 + value);
    return value;
  }
  bool good() const { return true; }
};

/// Returns the number of cells.
uint32_t count_cells(const CellMask& mask, Index3 cells) {
  uint32_t count = 0;
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      count += static_cast<uint32_t>(__builtin_popcountll(mask.row(y, z)));
    }
  }
  return count;
}

/// Counts the low bits that are zero in min and one in max of all the cells' intervals.
int32_t unused_bits(const BlockVoxels& block, const CellMask& mask) {
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
  return __builtin_ctz(used);
}

}  // namespace

struct IntervalResidual {
  int32_t below, beyond;  ///< how far the interval exceeds the range of the corners at each end
  int32_t range;          ///< greatest minus least corner
};

struct ChunkEncoder::Scratch {
  RansSymbol quad_symbols[256 * 16];  // by context and quad
  uint16_t mask_symbols[kMaxQuads];

  BandMasks band_masks;           // of one band
  const PointPlane nothing = {};  // substitute for the plane before the first
  PointPlane planes[kLatticeAcross];
  Row rows[kLatticeAcross][kLatticeAcross];  // by z, y
  Row first_row;                             // substitute for the rows before the first
  Energies energies;
  PlaneResiduals plane_residuals;
  IntervalResidual slice_intervals[kBlockCells * kBlockCells];
  PredictorFit fit;
  ResidualEncoder residuals;
  std::vector<uint16_t> words;
  BitWriter header_bits;
  BackwardBitWriter raw_bits;

  Scratch();
  template <class F>
  void for_each_row(Index3 cells, int32_t z, const Row*& last, F f);
  void set_values(const BlockVoxels& block, uint32_t point_count, ChunkHeader& header);
  void sample_row(int32_t y, int32_t z, const Neighbours& n, uint32_t stride, uint32_t& skip);
  void add_intervals(const BlockVoxels& block, const CellMask& mask, const ChunkHeader& header,
                     int32_t z, int32_t& interval_energy);
  void set_residuals(const BlockVoxels& block, const CellMask& mask, const ChunkHeader& header);
  uint16_t* put_mask(RansEncoder rans, const uint16_t* end) const;
  void encode(const BlockVoxels& block, const CellMask& mask, uint32_t count, uint32_t band_begin,
              uint32_t band_end, const uint16_t* mask_end, std::vector<std::byte>& out);
  const PointPlane& before(int32_t z) const { return z > 0 ? planes[z - 1] : nothing; }
};

ChunkEncoder::Scratch::Scratch() : rows{}, first_row{} {
  const QuadSlots slots;
  for (int context = 0; context < 256; ++context) {
    for (int quad = 0; quad < 16; ++quad) {
      quad_symbols[context * 16 + quad] =
          RansSymbol(slots.start[context][quad], slots.frequency[context][quad], kQuadBits);
    }
  }
}

/// Calls f(y, neighbours) for each row of plane z that has points, in coding order. last: the row
/// coded before (first_row for the first plane); on return, the last row of this plane.
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
void ChunkEncoder::Scratch::set_values(const BlockVoxels& block, uint32_t point_count,
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
      const QuantizedValue* quantized_values =
          block.voxels + (size_t(z) * (cells.y + 1) + y) * (cells.x + 1);
      const PointMask points_here = planes[z].points[y];
      all |= VectorOps::set_points(points_here.word[0], quantized_values, cells.x, values);
      if (points_here.has(cells.x)) {
        values[cells.x] = static_cast<int16_t>(quantized_values[cells.x] ^ 0x8000);
        all |= quantized_values[cells.x];
      }
      pad_row(rows[z][y], cells.x);
      sample_row(y, z, n, stride, skip);
    });
  }
  header.wide = all > 255;
  const PredictorFit::Weights weights = fit.solve(stride);
  header.fitted = weights.fitted;
  std::copy_n(&weights.taps[0][0], kClasses * kTaps, &header.taps[0][0]);
}

/// Adds every stride-th point of a row to the fit. skip: how many points to skip first; on return,
/// how many to skip in the next row.
void ChunkEncoder::Scratch::sample_row(int32_t y, int32_t z, const Neighbours& n, uint32_t stride,
                                       uint32_t& skip) {
  const int16_t* values = rows[z][y].value + kRowPad;
  for (int word = 0; word < 2; ++word) {
    const uint64_t here = planes[z].points[y].word[word];
    const auto count = static_cast<uint32_t>(__builtin_popcountll(here));
    if (skip < count) {
      const ClassBits classes = class_bits(planes[z], before(z), y, word);
      for (; skip < count; skip += stride) {
        const int bit = nth_bit(here, skip), x = 64 * word + bit;
        fit.add(class_at(classes.words, bit), taps_at(n, x), values + x);
      }
    }
    skip -= count;
  }
}

/// Adds the residuals of the intervals of slice z: how far each exceeds the range of the cell's
/// corners.
void ChunkEncoder::Scratch::add_intervals(const BlockVoxels& block, const CellMask& mask,
                                          const ChunkHeader& header, int32_t z,
                                          int32_t& interval_energy) {
  size_t count = 0;
  for (int32_t y = 0; y < block.cells.y; ++y) {
    if (mask.row(y, z) == 0) continue;
    // For all cells of the row, so that the compiler vectorises the loop.
    const int16_t *r00 = rows[z][y].value + kRowPad, *r10 = rows[z][y + 1].value + kRowPad,
                  *r01 = rows[z + 1][y].value + kRowPad, *r11 = rows[z + 1][y + 1].value + kRowPad;
    int16_t low[kLatticeAcross], high[kLatticeAcross];
    for (int32_t x = 0; x <= block.cells.x; ++x) {
      low[x] = std::min(std::min(r00[x], r10[x]), std::min(r01[x], r11[x]));
      high[x] = std::max(std::max(r00[x], r10[x]), std::max(r01[x], r11[x]));
    }
    const CellInterval* intervals =
        block.intervals + (size_t(z) * block.cells.y + y) * block.cells.x;
    IntervalResidual row[kBlockCells];
    for (int32_t x = 0; x < block.cells.x; ++x) {
      const int32_t min = (std::min(low[x], low[x + 1]) + 32768) >> header.interval_shift;
      const int32_t max = (std::max(high[x], high[x + 1]) + 32768) >> header.interval_shift;
      row[x] = {min - (intervals[x].min >> header.interval_shift),
                (intervals[x].max >> header.interval_shift) - max, max - min};
    }
    for (uint64_t bits = mask.row(y, z); bits; bits &= bits - 1) {
      slice_intervals[count++] = row[__builtin_ctzll(bits)];
    }
  }
  uint32_t* const entries = residuals.end();
  residuals.set_end(entries + 2 * count);
  for (size_t i = 0; i < count; ++i) {
    const auto [below, beyond, range] = slice_intervals[i];
    const int32_t before =
        i > 0 ? interval_energy_of(slice_intervals[i - 1].below, slice_intervals[i - 1].beyond)
              : interval_energy;
    const int32_t octave = half_octave_by_float(2 * range + before + 2);
    entries[2 * i] = residual_entry(fold(below), residual_key(octave, kIntervalMin));
    entries[2 * i + 1] = residual_entry(fold(beyond), residual_key(octave, kIntervalMax));
  }
  if (count > 0) {
    interval_energy =
        interval_energy_of(slice_intervals[count - 1].below, slice_intervals[count - 1].beyond);
  }
}

void ChunkEncoder::Scratch::set_residuals(const BlockVoxels& block, const CellMask& mask,
                                          const ChunkHeader& header) {
  const Index3 cells = block.cells;
  plane_residuals.set_predictor(header.taps, header.wide);
  energies.reset();
  const Row* last = &first_row;
  int32_t interval_energy = 0;
  for (int32_t z = 0; z <= cells.z; ++z) {
    plane_residuals.clear();
    for_each_row(cells, z, last, [&](int32_t y, const Neighbours& n) {
      plane_residuals.add_row(planes[z], before(z), y, n, rows[z][y]);
    });
    residuals.set_end(plane_residuals.put(energies, residuals.end()));
    // The intervals of slice z − 1 come after the points of plane z.
    if (block.has_intervals && z > 0) add_intervals(block, mask, header, z - 1, interval_energy);
  }
}

/// Encodes the mask's symbols up to `end`, and returns the end of the words.
uint16_t* ChunkEncoder::Scratch::put_mask(RansEncoder rans, const uint16_t* end) const {
  while (end != mask_symbols) rans.put<kQuadBits>(quad_symbols[*--end]);
  return rans.finish();
}

/// Appends a chunk of `count` cells. The mask's symbols were collected up to `mask_end`.
void ChunkEncoder::Scratch::encode(const BlockVoxels& block, const CellMask& mask, uint32_t count,
                                   uint32_t band_begin, uint32_t band_end, const uint16_t* mask_end,
                                   std::vector<std::byte>& out) {
  uint32_t point_count = 0;
  for (int32_t z = 0; z <= block.cells.z; ++z) point_count += planes[z].set(mask, block.cells, z);
  const size_t max_residuals = point_count + (block.has_intervals ? 2 * size_t{count} : 0);
  residuals.begin(max_residuals);

  ChunkHeader header;
  set_first_row(band_begin, band_end, first_row);
  set_values(block, point_count, header);
  header.wide |= block.corners_suffice;
  if (block.has_intervals) header.interval_shift = unused_bits(block, mask);
  for (const uint32_t below : kMergeBelow) header.levels.merge += point_count < below;
  set_residuals(block, mask, header);
  const size_t raw_bit_count = residuals.choose_models(header, block.has_intervals);

  header_bits.begin(kMaxHeaderBits);
  write_header(header, block.has_intervals, header_bits);
  raw_bits.begin(header_bits.size(), raw_bit_count);
  const auto max_symbols = max_residuals + static_cast<size_t>(mask_end - mask_symbols);
  if (words.size() < max_symbols + 2 * kRansStates) words.resize(max_symbols + 2 * kRansStates);
  RansEncoder rans(words.data());
  residuals.put(header, rans, raw_bits);
  header_bits.finish(out);
  raw_bits.finish(out);
  const uint16_t* const words_end = put_mask(rans, mask_end);
  out.insert(out.end(), reinterpret_cast<const std::byte*>(words.data()),
             reinterpret_cast<const std::byte*>(words_end));
}

ChunkEncoder::ChunkEncoder() : scratch_(std::make_unique<Scratch>()) {}
ChunkEncoder::ChunkEncoder(ChunkEncoder&&) noexcept = default;
ChunkEncoder& ChunkEncoder::operator=(ChunkEncoder&&) noexcept = default;
ChunkEncoder::~ChunkEncoder() = default;

uint32_t ChunkEncoder::encode(const BlockVoxels& block, uint32_t band_begin, uint32_t band_end,
                              std::vector<std::byte>& out) {
  BandMasks& masks = scratch_->band_masks;
  masks.set(block, band_begin, std::span(&band_end, 1));
  return encode(block, masks[0], band_begin, band_end, out);
}

uint32_t ChunkEncoder::encode(const BlockVoxels& block, const CellMask& mask, uint32_t band_begin,
                              uint32_t band_end, std::vector<std::byte>& out) {
  Scratch& s = *scratch_;
  const uint32_t count = count_cells(mask, block.cells);
  if (count == 0) return 0;
  BrickMask bricks = bricks_of(mask, block.cells);
  MaskEncoder mask_encoder{s.mask_symbols};
  code_mask(block.cells, bricks, mask, mask_encoder);
  s.encode(block, mask, count, band_begin, band_end, mask_encoder.to, out);
  return count;
}

void ChunkEncoder::encode_field(const BlockVoxels& field, const CellMask& mask, uint32_t value_end,
                                std::vector<std::byte>& out) {
  const uint32_t count = count_cells(mask, field.cells);
  if (count == 0) return;
  const BlockVoxels values{field.cells, field.voxels};
  scratch_->encode(values, mask, count, 0, value_end, scratch_->mask_symbols, out);
}

}  // namespace isosplat
