#include <algorithm>
#include <array>
#include <string>

#include "shared/codec/chunk_codec.h"
#include "shared/codec/chunk_header.h"
#include "shared/codec/rans.h"

namespace isosplat {
namespace {

/// Bytes before and after the copy of a chunk that may be read: more than kBatch points, a row of
/// intervals or the header can take, so that bounds are checked once for each.
constexpr size_t kSlack = 2048;

/// Points between two looks at the bounds.
constexpr int32_t kBatch = 256;

constexpr size_t kSmallestChunk = 4 * kRansStates + 1;

/// A token distribution: the token of each slot, and frequency | start << 16 of each token. Two
/// small tables, because many are in use at once and the cache is to hold them all.
struct TokenTable {
  bool built = false;
  uint8_t token[2048];
  uint32_t range[kTokens];

  void build(uint32_t shape) {
    uint16_t frequencies[kTokens];
    read_distribution(kTokenTable[shape], kTokens, kTokenTotal, frequencies);
    uint32_t start = 0;
    for (uint32_t t = 0; t < kTokens; ++t) {
      const uint32_t frequency = frequencies[t];
      std::fill_n(token + start, frequency, static_cast<uint8_t>(t));
      range[t] = frequency | start << 16;
      start += frequency;
    }
    built = true;
  }
};

/// What a context decodes with.
struct ContextModel {
  const TokenTable* table = nullptr;
  uint32_t shift = 0;
};

struct Found {
  uint32_t start, frequency, symbol;
};

/// A chunk from both its ends.
struct Streams {
  BitReader bits;
  RansDecoder rans;

  /// Whether what was read from one end has not been read from the other.
  bool within() const { return bits.position() <= rans.position(); }

  int32_t residual(const ContextModel& model) {
    const uint32_t token = rans.get<11>([&](uint32_t slot) {
      const uint32_t found = model.table->token[slot], range = model.table->range[found];
      return Found{range >> 16, range & 0xffff, found};
    });
    const uint32_t info = kTokenInfo.info[token];
    return unfold(((info & 0xffffff) << model.shift) + bits.get((info >> 24) + model.shift));
  }
};

template <class Ops>
struct MaskDecoder {
  static constexpr bool kDecodes = true;
  const QuadSlots& slots;
  Streams streams;

  uint32_t quad(uint32_t context, uint32_t) {
    return streams.rans.get<12>([&](uint32_t slot) {
      const uint32_t found = Ops::find_quad(slots.start[context], slot);
      return Found{slots.start[context][found], slots.frequency[context][found], found};
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
  TokenTable tables[kShapes];
  std::vector<uint8_t> bytes;

  CellMask mask;
  PointPlane plane[2];  // by z & 1, as is
  Row row[2][kLatticeAcross];
  Row last_row;  // the last of an earlier plane
  Energies energies;
  PlanePoints points;
  int32_t residuals[PlanePoints::kMost];  // of `points`
  ChunkHeader header;
  Predictor predictor;
  ContextModel models[kKeys];  // by residual_key()

  Scratch() : row{}, last_row{} {}

  /// Calls emit(place, the four rows of values from the cell's corner 0, 2, 4, 6 on, interval) for
  /// each cell in raster order; interval is null where it is that of the corners.
  template <class Ops, class Emit>
  Result<void> decode(std::span<const std::byte> chunk, const ChunkShape& shape, Emit emit);

  template <class Ops>
  void decode_row(Index3 cells, int32_t y, int32_t z, const Row*& last);
  void decode_residuals(Streams& streams, int32_t from, int32_t to);
  bool set_models();
};

/// Returns false where a context's model is missing that a level can lead to.
bool ChunkDecoder::Scratch::set_models() {
  ContextModel of_context[kContexts] = {};
  ContextModel any;
  for (int c = 0; c < kContexts; ++c) {
    if (header.model[c] == kNoModel) continue;
    const Model model = model_of(header.model[c]);
    TokenTable& table = tables[model.shape];
    if (!table.built) table.build(model.shape);
    any = of_context[c] = {&table, model.shift};
  }
  if (!any.table) return false;
  // A context that the encoder did not meet may be met in a malformed chunk: any model will do.
  for (int group = 0; group < kGroups; ++group) {
    for (int octave = 0; octave < kOctaves; ++octave) {
      const ContextModel& model =
          of_context[group * kLevels + header.levels.level_of_octave(octave)];
      models[residual_key(octave, group)] = model.table ? model : any;
    }
  }
  predictor.set(header.taps, header.wide);
  return true;
}

void ChunkDecoder::Scratch::decode_residuals(Streams& streams, int32_t from, int32_t to) {
  Streams local = streams;
  for (int32_t i = from; i < to; ++i) {
    residuals[i] = local.residual(models[points.key[i]]);
  }
  streams = local;
}

template <class Ops>
void ChunkDecoder::Scratch::decode_row(Index3 cells, int32_t y, int32_t z, const Row*& last) {
  const PointPlane &current = plane[z & 1], &previous = plane[~z & 1];
  const auto row_at = [&](int back, int32_t row_y) { return &row[(z - back) & 1][row_y]; };
  const Neighbours n = neighbours_of(current, previous, y, cells.y, row_at, last);
  Row& own = row[z & 1][y];
  fill_values(n, own);

  int16_t* const values = own.value + kRowPad;
  for (int32_t i = points.first[y]; i < points.first[y + 1]; ++i) {
    const int32_t x = points.x[i], residual = residuals[i];
    const ClassWeights& weights = predictor.classes[points.point_class[i]];
    const int32_t sum = Ops::sum_taps(taps_at(n, x), weights.rows);
    values[x] = static_cast<int16_t>(predictor.predict(weights, sum, values + x) + residual);
    energies.set(x, y, residual);
  }
  pad_row(own, cells.x);
  last = &own;
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
  Streams streams{BitReader(begin), RansDecoder(begin + chunk.size())};

  if (!streams.rans.starts_well()) return malformed("a coder state is outside its limits");
  if (!read_header(streams.bits, shape.has_intervals, header)) return malformed("bad header");
  if (!streams.within()) return truncated();
  if (!set_models()) return malformed("no model");

  mask.clear();
  BrickMask bricks;
  MaskDecoder<Ops> mask_decoder{quad_slots, streams};
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

  energies.reset();
  set_first_row(shape.slab_begin, shape.slab_end, last_row);
  const Row* last = &last_row;
  plane[1].clear();  // there is none before z = 0
  int32_t interval_energy = 0;
  for (int32_t z = 0; z <= cells.z; ++z) {
    if (plane[z & 1].set(mask, cells, z) == 0) continue;
    points.set<Ops>(plane[z & 1], plane[~z & 1], energies, cells.y);
    const int32_t in_plane = points.first[cells.y + 1];
    for (int32_t i = 0; i < in_plane; i += kBatch) {
      decode_residuals(streams, i, std::min(i + kBatch, in_plane));
      if (!streams.within()) return truncated();
    }
    for (int32_t y = 0; y <= cells.y; ++y) {
      if (points.first[y] != points.first[y + 1]) decode_row<Ops>(cells, y, z, last);
    }
    // The next plane but one takes this one's place: keep its last row.
    if (last != &last_row) last_row = *last;
    last = &last_row;
    if (z == 0) continue;

    for (int32_t y = 0; y < cells.y; ++y) {
      const int16_t* const r00 = row[~z & 1][y].value + kRowPad;
      const int16_t* const r10 = row[~z & 1][y + 1].value + kRowPad;
      const int16_t* const r01 = row[z & 1][y].value + kRowPad;
      const int16_t* const r11 = row[z & 1][y + 1].value + kRowPad;
      const auto row_place = static_cast<uint32_t>(y << 6 | (z - 1) << 12);
      for (uint64_t bits = mask.row(y, z - 1); bits; bits &= bits - 1) {
        const auto x = static_cast<uint32_t>(__builtin_ctzll(bits));
        if (!shape.has_intervals) {
          emit(row_place | x, r00 + x, r10 + x, r01 + x, r11 + x, nullptr);
          continue;
        }
        const CellInterval range =
            header.shifted(corner_interval(ScalarOps::corners(r00 + x, r10 + x, r01 + x, r11 + x)));
        const int32_t octave = interval_octave(range, interval_energy);
        const int32_t below = streams.residual(models[residual_key(octave, kIntervalMin)]);
        const int32_t beyond = streams.residual(models[residual_key(octave, kIntervalMax)]);
        interval_energy = interval_energy_of(below, beyond);
        const auto min = static_cast<uint32_t>(range.min - below) << header.interval_shift;
        const auto end = static_cast<uint32_t>(range.max + beyond + 1) << header.interval_shift;
        const CellInterval interval{static_cast<Code>(min), static_cast<Code>(end - 1)};
        if (interval.min >= interval.max) return malformed("a cell's interval is empty");
        emit(row_place | x, r00 + x, r10 + x, r01 + x, r11 + x, &interval);
      }
      if (!streams.within()) return truncated();
    }
  }
  if (!streams.rans.ends_well() || !streams.bits.padding_is_zero()) {
    return malformed("the coder does not end where it began");
  }
  if (streams.bits.position() != streams.rans.position()) {
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
