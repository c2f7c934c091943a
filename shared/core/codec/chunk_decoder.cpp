#include <algorithm>
#include <array>
#include <string>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/codec/chunk_header.h"
#include "shared/core/codec/pack_cells.h"
#include "shared/core/codec/residual_decoder.h"

namespace isosplat {
namespace {

/// The number of bytes before and after the copy of a chunk that can be read. It exceeds the bytes
/// of kBatch points, of the intervals of a row, and of the header, so that the bounds are checked
/// only once for each of these.
constexpr size_t kSlack = 2048;

/// The number of points that are decoded between two checks of the bounds.
constexpr int32_t kBatch = 256;

constexpr uint32_t kMaxCells = kBlockCells * kBlockCells * kBlockCells;

constexpr size_t kSmallestChunk = 4 * kRansStates + 1;

template <class Ops>
struct MaskDecoder {
  static constexpr bool kDecodes = true;
  const QuadSlots* slots;
  ChunkStreams streams;

  uint32_t quad(uint32_t context, uint32_t) {
    return streams.rans.get<12>([&](uint32_t slot) {
      const uint32_t found = Ops::find_quad(slots->start[context], slot);
      return FoundSymbol{slots->start[context][found], slots->frequency[context][found], found};
    });
  }
  bool good() const { return streams.within(); }
};

tl::unexpected<Error> truncated() {
  return fail(Status::truncated, "chunk: the bytes end before its cells do: fetch it again");
}
tl::unexpected<Error> malformed(const char* what) {
  return fail(Status::malformed_chunk,
              std::string("chunk: ") + what + ": rebuild the store, or fetch the chunk again");
}

}  // namespace

struct ChunkDecoder::Scratch {
  QuadSlots quad_slots;
  std::vector<uint8_t> bytes;

  CellMask mask;
  // Only the current and the previous plane are kept, each at index z & 1.
  PointPlane plane[2];
  Row row[2][kLatticeAcross];
  Row last_row;               // the last row of an earlier plane
  const Row* last = nullptr;  // the row decoded most recently
  Energies energies;
  PlanePoints points;
  // For each of `points`: the residual, Energies::energy_of() it, and the part of its weighted sum
  // that does not depend on points of the same row.
  int32_t residuals[PlanePoints::kMax];
  int16_t residual_energies[PlanePoints::kMax];
  int32_t sums[PlanePoints::kMax + 3];
  ChunkHeader header;
  Predictor predictor;
  ResidualModels models;
  IntervalRow intervals;
  int32_t interval_energy = 0;  // interval_energy_of() the cell decoded before

  Scratch() : row{}, last_row{} {}

  /// Calls emit(cells, row_cell, rows, intervals) for each row that has cells of the chunk.
  /// pack_cells() documents the arguments. mask_is_known: the chunk has no mask, and `mask` is set.
  template <class Ops, class Emit>
  Result<void> decode(std::span<const std::byte> chunk, const ChunkShape& shape, Emit emit,
                      bool mask_is_known = false);

  ChunkStreams copy_chunk(std::span<const std::byte> chunk);
  template <class Ops>
  Result<void> decode_mask(ChunkStreams& streams, const ChunkShape& shape);
  template <class Ops>
  Result<bool> decode_plane_residuals(ChunkStreams& streams, Index3 cells, int32_t z);
  template <class Ops, class Emit>
  Result<void> decode_plane(ChunkStreams& streams, const ChunkShape& shape, int32_t z, Emit& emit);
  template <class Ops>
  void decode_row(Index3 cells, int32_t y, int32_t z);
  void decode_residuals(ChunkStreams& streams, int32_t from, int32_t to);
  bool decode_intervals(ChunkStreams& streams, uint64_t in_row, const CellRows& rows);
};

/// Decodes the residuals of points `from` to `to` − 1 of the plane.
void ChunkDecoder::Scratch::decode_residuals(ChunkStreams& streams, int32_t from, int32_t to) {
  ChunkStreams local = streams;
  int32_t i = from;
  const auto next = [&] {
    residuals[i] = local.residual(models[points.key[i]]);
    ++i;
  };
  // Four residuals at a time, one from each rANS state.
  while (i + kRansStates <= to) next(), next(), next(), next();
  while (i < to) next();
  streams = local;
  for (i = from; i < to; ++i) residual_energies[i] = Energies::energy_of(residuals[i]);
}

template <class Ops>
void ChunkDecoder::Scratch::decode_row(Index3 cells, int32_t y, int32_t z) {
  const PointPlane &current = plane[z & 1], &previous = plane[~z & 1];
  const auto row_at = [&](int back, int32_t row_y) { return &row[(z - back) & 1][row_y]; };
  const Neighbours n = neighbours_of(current, previous, y, cells.y, row_at, last);
  Row& own = row[z & 1][y];
  fill_values(n, own);

  int16_t* const values = own.value + kRowPad;
  // Computes first the sums that do not depend on other points of the row, four points at a time.
  // The last four may extend beyond the row.
  const int32_t first = points.first[y], end = points.first[y + 1];
  for (int32_t i = first; i < end; i += 4) {
    const auto point = [&](int k) {
      const int32_t x = points.x[i + k];
      return WeightedTaps{taps_at(n, x), values + x - 1,
                          predictor.classes[points.point_class[i + k]].rows};
    };
    Ops::sum_four(point, sums + i);
  }
  int16_t* const energies_here = energies.row(y);
  int32_t value = 0;
  for (int32_t i = first; i < end; ++i) {
    const int32_t x = points.x[i];
    const ClassWeights& weights = predictor.classes[points.point_class[i]];
    // A prediction has to wait for the value on the left only, which stays in a register.
    const int32_t others = sums[i] + weights.left2 * values[x - 2];
    value =
        static_cast<int16_t>(predictor.prediction(others + weights.left * value) + residuals[i]);
    values[x] = static_cast<int16_t>(value);
    energies_here[x] = residual_energies[i];
  }
  pad_row(own, cells.x);
  last = &own;
}

/// Decodes the intervals of a row of cells. Returns false if one of them is empty.
bool ChunkDecoder::Scratch::decode_intervals(ChunkStreams& streams, uint64_t in_row,
                                             const CellRows& rows) {
  bool good = true;
  for (; in_row; in_row &= in_row - 1) {
    const int32_t x = __builtin_ctzll(in_row);
    const CellInterval range = header.shifted(corner_interval(rows.corners(x)));
    const int32_t octave = interval_octave(range, interval_energy);
    const int32_t below = streams.residual(models[residual_key(octave, kIntervalMin)]);
    const int32_t beyond = streams.residual(models[residual_key(octave, kIntervalMax)]);
    interval_energy = interval_energy_of(below, beyond);
    const auto min = static_cast<uint32_t>(range.min - below) << header.interval_shift;
    const auto end = static_cast<uint32_t>(range.max + beyond + 1) << header.interval_shift;
    intervals.min[x] = static_cast<QuantizedValue>(min);
    intervals.max[x] = static_cast<QuantizedValue>(end - 1);
    good &= intervals.min[x] < intervals.max[x];
  }
  return good;
}

/// Copies the chunk to memory with kSlack zero bytes around it.
ChunkStreams ChunkDecoder::Scratch::copy_chunk(std::span<const std::byte> chunk) {
  bytes.resize(chunk.size() + 2 * kSlack);
  std::memset(bytes.data(), 0, kSlack);
  std::memcpy(bytes.data() + kSlack, chunk.data(), chunk.size());
  std::memset(bytes.data() + kSlack + chunk.size(), 0, kSlack);
  const uint8_t* const begin = bytes.data() + kSlack;
  return {BitReader(begin), RansDecoder(begin + chunk.size())};
}

/// Decodes which cells the chunk has.
template <class Ops>
Result<void> ChunkDecoder::Scratch::decode_mask(ChunkStreams& streams, const ChunkShape& shape) {
  const Index3 cells = shape.block_cells;
  mask.clear();
  BrickMask bricks;
  MaskDecoder<Ops> mask_decoder{&quad_slots, streams};
  const bool mask_is_good = code_mask(cells, bricks, mask, mask_decoder);
  streams = mask_decoder.streams;
  if (!mask_is_good) {
    return streams.within() ? malformed("cells outside the block") : truncated();
  }
  uint32_t count = 0;
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      count += static_cast<uint32_t>(__builtin_popcountll(mask.row(y, z)));
    }
  }
  if (count != shape.cell_count) return malformed("holds another number of cells than stated");
  return {};
}

/// Lists the points of plane z, and decodes their residuals. Returns false if there are no points.
template <class Ops>
Result<bool> ChunkDecoder::Scratch::decode_plane_residuals(ChunkStreams& streams, Index3 cells,
                                                           int32_t z) {
  if (plane[z & 1].set(mask, cells, z) == 0) return false;
  points.set<Ops>(plane[z & 1], plane[~z & 1], energies, cells.y);
  const int32_t in_plane = points.first[cells.y + 1];
  for (int32_t i = 0; i < in_plane; i += kBatch) {
    decode_residuals(streams, i, std::min(i + kBatch, in_plane));
    if (!streams.within()) return truncated();
  }
  return true;
}

/// Decodes the points of plane z and the cells of slice z − 1.
template <class Ops, class Emit>
Result<void> ChunkDecoder::Scratch::decode_plane(ChunkStreams& streams, const ChunkShape& shape,
                                                 int32_t z, Emit& emit) {
  const Index3 cells = shape.block_cells;
  const Result<bool> any = decode_plane_residuals<Ops>(streams, cells, z);
  if (!any) return tl::unexpected(any.error());
  if (!*any) return {};
  // Cells follow kLag rows behind the points: reading values right after they were stored would
  // stall the processor.
  constexpr int32_t kLag = 2;
  for (int32_t y = 0; y < cells.y + kLag; ++y) {
    if (y <= cells.y && points.first[y] != points.first[y + 1]) decode_row<Ops>(cells, y, z);
    if (z == 0 || y < kLag) continue;
    const int32_t cell_y = y - kLag;
    const uint64_t in_row = mask.row(cell_y, z - 1);
    if (!in_row) continue;
    const CellRows rows(row[~z & 1][cell_y], row[~z & 1][cell_y + 1], row[z & 1][cell_y],
                        row[z & 1][cell_y + 1]);
    if (shape.has_intervals) {
      if (!decode_intervals(streams, in_row, rows)) return malformed("a cell's interval is empty");
      if (!streams.within()) return truncated();
    }
    emit(in_row, static_cast<uint32_t>(cell_y << 6 | (z - 1) << 12), rows,
         shape.has_intervals ? &intervals : nullptr);
  }
  // Plane z + 2 will overwrite this one: keep its last row.
  if (last != &last_row) last_row = *last;
  last = &last_row;
  return {};
}

template <class Ops, class Emit>
Result<void> ChunkDecoder::Scratch::decode(std::span<const std::byte> chunk,
                                           const ChunkShape& shape, Emit emit, bool mask_is_known) {
  const Index3 cells = shape.block_cells;
  if (std::min({cells.x, cells.y, cells.z}) < 1 ||
      std::max({cells.x, cells.y, cells.z}) > kBlockCells || shape.cell_count < 1 ||
      shape.cell_count > static_cast<uint32_t>(cells.x * cells.y * cells.z) ||
      shape.band_begin >= shape.band_end || shape.band_end > 65536) {
    return fail(Status::invalid_argument,
                "chunk: block size, band or cell count is outside its limits");
  }
  if (chunk.size() < kSmallestChunk) return truncated();

  ChunkStreams streams = copy_chunk(chunk);
  if (!streams.rans.has_valid_initial_states())
    return malformed("a coder state is outside its limits");
  if (!read_header(streams.bits, shape.has_intervals, header)) return malformed("bad header");
  if (!streams.within()) return truncated();
  if (!models.set(header)) return malformed("no model");
  predictor.set(header.taps, header.wide);
  if (!mask_is_known) {
    if (const auto done = decode_mask<Ops>(streams, shape); !done) return done;
  }

  energies.reset();
  set_first_row(shape.band_begin, shape.band_end, last_row);
  last = &last_row;
  plane[1].clear();  // no plane precedes z = 0
  interval_energy = 0;
  for (int32_t z = 0; z <= cells.z; ++z) {
    if (const auto done = decode_plane<Ops>(streams, shape, z, emit); !done) return done;
  }
  if (!streams.rans.has_valid_final_states() || !streams.bits.padding_is_zero()) {
    return malformed("the coder does not end where it began");
  }
  if (streams.bits.position() != streams.rans.position()) {
    return malformed("bytes are left over");
  }
  return {};
}

namespace {

/// In a chunk of values below 256 that is marked as wide, the corners suffice.
void narrow_where_corners_suffice(std::span<PackedSample> samples) {
  for (const PackedSample& sample : samples) {
    if (sample.word[1] >> 16 > 255) return;
  }
  for (PackedSample& sample : samples) {
    const UnpackedSample cell = unpack_sample(sample);
    CellCorners corners;
    for (size_t i = 0; i < 8; ++i) corners[i] = static_cast<QuantizedValue>(cell.corners[i]);
    sample = pack_sample(cell.cell, corner_interval(corners), corners);
  }
}

}  // namespace

ChunkDecoder::ChunkDecoder() : scratch_(std::make_unique<Scratch>()) {}
ChunkDecoder::ChunkDecoder(ChunkDecoder&&) noexcept = default;
ChunkDecoder& ChunkDecoder::operator=(ChunkDecoder&&) noexcept = default;
ChunkDecoder::~ChunkDecoder() = default;

Result<void> ChunkDecoder::decode(std::span<const std::byte> bytes, const ChunkShape& shape,
                                  DecodedCells& out) {
  // Cells are emitted only after their number was checked against cell_count.
  const uint32_t count = std::min(shape.cell_count, kMaxCells);
  out.cell.resize(count);
  out.corners.resize(count);
  out.interval.resize(count);
  size_t i = 0;
  const Result<void> done = scratch_->decode<VectorOps>(
      bytes, shape,
      [&](uint64_t in_row, uint32_t row_cell, const CellRows& rows, const IntervalRow* intervals) {
        for (; in_row; in_row &= in_row - 1, ++i) {
          const int32_t x = __builtin_ctzll(in_row);
          const CellCorners corners = rows.corners(x);
          out.cell[i] = row_cell | static_cast<uint32_t>(x);
          out.corners[i] = corners;
          out.interval[i] = intervals ? CellInterval{intervals->min[x], intervals->max[x]}
                                      : corner_interval(corners);
        }
      });
  if (!done) {
    out.cell.clear();
    out.corners.clear();
    out.interval.clear();
  }
  return done;
}

Result<void> ChunkDecoder::decode_packed(std::span<const std::byte> bytes, const ChunkShape& shape,
                                         std::vector<PackedSample>& out) {
  // Not cleared before: the samples of an earlier call are overwritten, and need no initialisation.
  out.resize(std::min(shape.cell_count, kMaxCells) + kPackedSlack);
  PackedSample* to = out.data();
  const Result<void> done = scratch_->decode<VectorOps>(
      bytes, shape,
      [&](uint64_t in_row, uint32_t row_cell, const CellRows& rows, const IntervalRow* intervals) {
        to = pack_cells(in_row, row_cell, rows, intervals, to);
      });
  out.resize(done ? shape.cell_count : 0);
  if (scratch_->header.wide && shape.has_intervals) narrow_where_corners_suffice(out);
  return done;
}

Result<void> ChunkDecoder::decode_field(std::span<const std::byte> bytes, Index3 block_cells,
                                        std::span<const uint32_t> cells, uint32_t value_end,
                                        std::vector<CellCorners>& out) {
  out.clear();
  if (cells.size() > kMaxCells || !scratch_->mask.set(cells, block_cells)) {
    return fail(Status::invalid_argument,
                "field chunk: expected the ascending cells of a chunk, found others");
  }
  const ChunkShape shape{block_cells, 0, value_end, static_cast<uint32_t>(cells.size())};
  out.resize(cells.size());
  size_t i = 0;
  const Result<void> done = scratch_->decode<VectorOps>(
      bytes, shape,
      [&](uint64_t in_row, uint32_t, const CellRows& rows, const IntervalRow*) {
        for (; in_row; in_row &= in_row - 1) out[i++] = rows.corners(__builtin_ctzll(in_row));
      },
      true);
  if (!done) out.clear();
  return done;
}

}  // namespace isosplat
