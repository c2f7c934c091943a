#include <algorithm>
#include <array>
#include <string>

#include "shared/codec/chunk_codec.h"
#include "shared/codec/chunk_header.h"
#include "shared/codec/rans.h"

namespace isosplat {
namespace {

/// Bytes before and after the copy of a chunk that may be read: more than a row of the lattice, a
/// slice's row of intervals or the header can take, so that bounds are checked once for each.
constexpr size_t kSlack = 2048;

constexpr size_t kSmallestChunk = 4 * kRansStates + 1;

/// A slot of a token distribution: frequency | start << 11 | token << 22.
struct TokenTable {
  bool built = false;
  uint32_t slot[2048];

  void build(const uint16_t* frequencies) {
    uint32_t start = 0;
    for (uint32_t token = 0; token < kTokens; ++token) {
      const uint32_t frequency = frequencies[token];
      std::fill_n(slot + start, frequency, frequency | start << 11 | token << 22);
      start += frequency;
    }
    built = true;
  }
};

/// What a context decodes with.
struct ContextModel {
  const uint32_t* slots = nullptr;
  uint32_t shift = 0;
};

struct Found {
  uint32_t start, frequency, symbol;
};

/// Both ends of a chunk.
struct Streams {
  RansDecoder rans;
  BitReader bits;
  const uint8_t* end;

  /// Whether all that was read so far is in the chunk.
  bool within() const { return rans.position() + bits.bytes_read() <= end; }

  int32_t residual(const ContextModel& model) {
    const uint32_t token = rans.get<11>([&](uint32_t slot) {
      const uint32_t entry = model.slots[slot];
      return Found{entry >> 11 & 0x7ff, entry & 0x7ff, entry >> 22};
    });
    const uint32_t raw_bits = token_bits(token) + model.shift;
    return unfold((token_base(token) << model.shift) + bits.get(raw_bits));
  }
};

template <class Ops>
struct MaskDecoder {
  const QuadStarts& starts;
  Streams& streams;

  uint32_t quad(const uint16_t* quad_starts, const uint16_t* frequencies) {
    return streams.rans.get<12>([&](uint32_t slot) {
      const uint32_t found = Ops::find_quad(quad_starts, slot);
      return Found{quad_starts[found], frequencies[found], found};
    });
  }
  uint32_t brick(uint32_t context, uint64_t) {
    return quad(starts.brick[context], kBrickQuads[context]);
  }
  uint32_t cell(uint32_t context, uint64_t) {
    return quad(starts.cell[context], kCellQuads[context]);
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
  QuadStarts quad_starts;
  TokenTable tables[kShapes];
  std::vector<uint8_t> bytes;

  CellMask mask;
  PointPlane plane[2];  // by z & 1, as are
  ValueRow value[2][kLatticeAcross];
  EnergyRow energy[2][kLatticeAcross];
  ValueRow last_value;  // of the last row of an earlier plane
  EnergyRow last_energy;
  ChunkHeader header;
  Predictor predictor;
  ContextModel models[kContexts];

  Scratch() : value{}, energy{}, last_value{}, last_energy{} {}

  /// Calls emit(place, the four rows of values from the cell's corner 0, 2, 4, 6 on, interval) for
  /// each cell in raster order; interval is null where it is that of the corners.
  template <class Ops, class Emit>
  Result<void> decode(std::span<const std::byte> chunk, const ChunkShape& shape, Emit emit);

  template <class Ops>
  void decode_row(Streams& streams, int32_t cells_y, int32_t cells_x, int32_t y, int32_t z,
                  RowPointers& last);
  bool set_models();
};

/// Returns false where a context's model is missing that a level can lead to.
bool ChunkDecoder::Scratch::set_models() {
  const TokenTable* any = nullptr;
  for (int c = 0; c < kContexts; ++c) {
    models[c] = {};
    if (header.model[c] == kNoModel) continue;
    const Model model = model_of(header.model[c]);
    TokenTable& table = tables[model.shape];
    if (!table.built) table.build(kTokenShapes[model.shape]);
    models[c] = {table.slot, model.shift};
    any = &table;
  }
  if (!any) return false;
  // A context that the encoder did not meet may be met in a malformed chunk: any table will do.
  for (ContextModel& model : models) {
    if (!model.slots) model.slots = any->slot;
  }
  for (int c = 0; c < kClasses; ++c) predictor.classes[c].set(header.taps[c]);
  predictor.greatest = header.wide ? 32767 : 255 - 32768;
  return true;
}

template <class Ops>
void ChunkDecoder::Scratch::decode_row(Streams& streams, int32_t cells_y, int32_t cells_x,
                                       int32_t y, int32_t z, RowPointers& last) {
  const PointPlane &current = plane[z & 1], &previous = plane[~z & 1];
  const auto row_of = [&](int back, int32_t row_y) {
    return RowPointers{value[(z - back) & 1][row_y].at + kRowPad,
                       energy[(z - back) & 1][row_y].at + kRowPad};
  };
  const Neighbours n = neighbours_of(current, previous, y, cells_y, row_of, last);
  int16_t* const values = value[z & 1][y].at + kRowPad;
  int16_t* const energies = energy[z & 1][y].at + kRowPad;
  fill_values(n, values);
  fill_energies(n, energies);
  for (int word = 0; word < 2; ++word) {
    const ClassBits classes = class_bits(current, previous, y, word);
    for (uint64_t bits = current.points[y].word[word]; bits; bits &= bits - 1) {
      const int bit = __builtin_ctzll(bits), x = 64 * word + bit;
      const uint32_t point_class = classes.at(bit);
      const ClassWeights& weights = predictor.classes[point_class];
      const Sums sums = Ops::sum_taps(taps_at(n, x), weights.rows);
      const ContextModel& model =
          models[group_of_class(point_class) * kLevels + header.levels.level(sums.energy)];
      const int32_t residual = streams.residual(model);
      values[x] =
          static_cast<int16_t>(predictor.predict(weights, sums.prediction, values + x) + residual);
      energies[x] = static_cast<int16_t>(std::min(std::abs(residual), kMaxEnergy));
    }
  }
  pad_row(values, cells_x);
  pad_row(energies, cells_x);
  last = {values, energies};
}

template <class Ops, class Emit>
Result<void> ChunkDecoder::Scratch::decode(std::span<const std::byte> chunk,
                                           const ChunkShape& shape, Emit emit) {
  const Index3 cells = shape.block_cells;
  if (std::min({cells.x, cells.y, cells.z}) < 1 ||
      std::max({cells.x, cells.y, cells.z}) > kBlockCells || shape.cell_count < 1 ||
      shape.cell_count > static_cast<uint32_t>(cells.x * cells.y * cells.z) ||
      shape.slab_begin >= shape.slab_end || shape.slab_end > 65536) {
    return fail(Status::invalid_argument,
                "chunk: block size, slab or cell count is outside its limits");
  }
  if (chunk.size() < kSmallestChunk) return truncated();

  bytes.resize(chunk.size() + 2 * kSlack);
  std::memset(bytes.data(), 0, kSlack);
  std::memcpy(bytes.data() + kSlack, chunk.data(), chunk.size());
  std::memset(bytes.data() + kSlack + chunk.size(), 0, kSlack);
  const uint8_t* const begin = bytes.data() + kSlack;
  const uint8_t* const end = begin + chunk.size();
  Streams streams{RansDecoder(begin), BitReader(end), end};

  if (!streams.rans.starts_well()) return malformed("a coder state is outside its limits");
  if (!read_header(streams.bits, shape.has_intervals, header)) return malformed("bad header");
  if (!streams.within()) return truncated();
  if (!set_models()) return malformed("no model");

  mask.clear();
  BrickMask bricks;
  MaskDecoder<Ops> mask_decoder{quad_starts, streams};
  if (!code_mask(cells, bricks, mask, mask_decoder)) {
    return streams.within() ? malformed("cells outside the block") : truncated();
  }
  uint32_t count = 0;
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      count += static_cast<uint32_t>(__builtin_popcountll(mask.row(y, z)));
    }
  }
  if (count != shape.cell_count) return malformed("holds another number of cells than stated");

  set_first_row(shape.slab_begin, shape.slab_end, last_value, last_energy);
  RowPointers last{last_value.at + kRowPad, last_energy.at + kRowPad};
  plane[1].clear();  // there is none before z = 0
  int32_t interval_energy = 0;
  for (int32_t z = 0; z <= cells.z; ++z) {
    if (plane[z & 1].set(mask, cells, z) == 0) continue;
    for (int32_t y = 0; y <= cells.y; ++y) {
      if (!plane[z & 1].points[y].any()) continue;
      decode_row<Ops>(streams, cells.y, cells.x, y, z, last);
      if (!streams.within()) return truncated();
    }
    // The next plane but one takes this one's place: keep its last row.
    if (last.value != last_value.at + kRowPad) {
      std::memcpy(last_value.at, last.value - kRowPad, sizeof last_value);
      std::memcpy(last_energy.at, last.energy - kRowPad, sizeof last_energy);
      last = {last_value.at + kRowPad, last_energy.at + kRowPad};
    }
    if (z == 0) continue;

    for (int32_t y = 0; y < cells.y; ++y) {
      const int16_t* const r00 = value[~z & 1][y].at + kRowPad;
      const int16_t* const r10 = value[~z & 1][y + 1].at + kRowPad;
      const int16_t* const r01 = value[z & 1][y].at + kRowPad;
      const int16_t* const r11 = value[z & 1][y + 1].at + kRowPad;
      const auto row_place = static_cast<uint32_t>(y << 6 | (z - 1) << 12);
      for (uint64_t bits = mask.row(y, z - 1); bits; bits &= bits - 1) {
        const auto x = static_cast<uint32_t>(__builtin_ctzll(bits));
        if (!shape.has_intervals) {
          emit(row_place | x, r00 + x, r10 + x, r01 + x, r11 + x, nullptr);
          continue;
        }
        const CellInterval range =
            corner_interval(ScalarOps::corners(r00 + x, r10 + x, r01 + x, r11 + x));
        const int32_t level = header.levels.level(interval_energy_of(range, interval_energy));
        const int32_t below = streams.residual(models[kIntervalMin * kLevels + level]);
        const int32_t beyond = streams.residual(models[kIntervalMax * kLevels + level]);
        interval_energy = std::min(std::abs(below) + std::abs(beyond), 65535);
        const CellInterval interval{static_cast<Code>(range.min - below),
                                    static_cast<Code>(range.max + beyond)};
        if (interval.min >= interval.max) return malformed("a cell's interval is empty");
        emit(row_place | x, r00 + x, r10 + x, r01 + x, r11 + x, &interval);
      }
      if (!streams.within()) return truncated();
    }
  }
  if (!streams.rans.ends_well() || !streams.bits.padding_is_zero()) {
    return malformed("the coder does not end where it began");
  }
  if (streams.rans.position() + streams.bits.bytes_read() != end) {
    return malformed("bytes are left over");
  }
  return {};
}

ChunkDecoder::ChunkDecoder() : scratch_(std::make_unique<Scratch>()) {}
ChunkDecoder::ChunkDecoder(ChunkDecoder&&) noexcept = default;
ChunkDecoder& ChunkDecoder::operator=(ChunkDecoder&&) noexcept = default;
ChunkDecoder::~ChunkDecoder() = default;

Result<void> ChunkDecoder::decode(std::span<const std::byte> bytes, const ChunkShape& shape,
                                  DecodedCells& out) {
  out.cell.clear();
  out.corners.clear();
  out.interval.clear();
  return scratch_->decode<ScalarOps>(
      bytes, shape,
      [&](uint32_t place, const int16_t* r00, const int16_t* r10, const int16_t* r01,
          const int16_t* r11, const CellInterval* interval) {
        out.cell.push_back(place);
        out.corners.push_back(ScalarOps::corners(r00, r10, r01, r11));
        out.interval.push_back(interval ? *interval : corner_interval(out.corners.back()));
      });
}

Result<void> ChunkDecoder::decode_packed(std::span<const std::byte> bytes, const ChunkShape& shape,
                                         std::vector<PackedSample>& out) {
  out.clear();
  // Cells are emitted only once their number is known to be cell_count, and that to be possible.
  constexpr uint32_t kMostCells = kBlockCells * kBlockCells * kBlockCells;
  out.resize(std::min(shape.cell_count, kMostCells));
  PackedSample* to = out.data();
  const Result<void> done = scratch_->decode<VectorOps>(
      bytes, shape,
      [&](uint32_t place, const int16_t* r00, const int16_t* r10, const int16_t* r01,
          const int16_t* r11, const CellInterval* interval) {
        *to++ = VectorOps::pack(place, r00, r10, r01, r11, interval);
      });
  if (!done) out.clear();
  return done;
}

}  // namespace isosplat
