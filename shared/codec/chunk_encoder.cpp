#include <algorithm>
#include <array>

#include "shared/codec/chunk_codec.h"
#include "shared/codec/chunk_header.h"
#include "shared/codec/rans.h"

namespace isosplat {
namespace {

/// Points that the predictor is fitted to, at most about so many.
constexpr uint32_t kFitSamples = 4096;

/// Chunks with fewer residuals than these merge 16, 8, 4, 2 levels.
constexpr uint32_t kMergeBelow[] = {64, 160, 400, 1000};

/// −log2(frequency / 2048) in 1/256 bit, by integers, so that it is the same everywhere.
uint32_t cost_of(uint32_t frequency) {
  uint64_t x = uint64_t{frequency} << 32;
  uint32_t log = 0;
  while (x >= uint64_t{2} << 32) x >>= 1, log += 256;
  for (uint32_t bit = 128; bit; bit >>= 1) {
    const uint64_t root = x >> 16;
    x = root * root;
    if (x >= uint64_t{2} << 32) x >>= 1, log += bit;
  }
  return 11 * 256 - log;
}

struct MaskEncoder {
  const QuadStarts& starts;
  RansEncoder& rans;

  uint32_t brick(uint32_t context, uint64_t quad) {
    rans.put(starts.brick[context][quad], kBrickQuads[context][quad], 12);
    return static_cast<uint32_t>(quad);
  }
  uint32_t cell(uint32_t context, uint64_t quad) {
    rans.put(starts.cell[context][quad], kCellQuads[context][quad], 12);
    return static_cast<uint32_t>(quad);
  }
  bool good() const { return true; }
};

}  // namespace

struct ChunkEncoder::Scratch {
  QuadStarts quad_starts;
  uint16_t token_start[kShapes][kTokens];
  uint32_t token_cost[kShapes][kTokens];

  CellMask mask;
  PointPlane plane[kLatticeAcross];
  ValueRow value[kLatticeAcross][kLatticeAcross];  // by z, y
  EnergyRow energy[2][kLatticeAcross];             // by z & 1, y
  ValueRow first_value;                            // what stands in for rows before the first
  EnergyRow first_energy;
  PredictorFit fit;
  std::vector<uint32_t> residuals;  // folded | half octave << 18 | group << 24
  RansEncoder rans;
  BitWriter bit_writer;

  Scratch();
  uint32_t set_mask(const BlockView& block, uint32_t begin, uint32_t end);
  template <class F>
  void for_each_row(Index3 cells, F f);
  void set_values(const BlockView& block, ChunkHeader& header);
  void fit_predictor(const BlockView& block, uint32_t points, ChunkHeader& header);
  void set_residuals(const BlockView& block, const ChunkHeader& header);
  void choose_models(ChunkHeader& header);
};

ChunkEncoder::Scratch::Scratch() : value{}, energy{}, first_value{}, first_energy{} {
  for (int shape = 0; shape < kShapes; ++shape) {
    uint32_t start = 0;
    for (int token = 0; token < kTokens; ++token) {
      const uint32_t frequency = kTokenShapes[shape][token];
      token_start[shape][token] = static_cast<uint16_t>(start);
      token_cost[shape][token] = cost_of(frequency);
      start += frequency;
    }
  }
}

/// Returns the number of cells.
uint32_t ChunkEncoder::Scratch::set_mask(const BlockView& block, uint32_t begin, uint32_t end) {
  mask.clear();
  uint32_t count = 0;
  const CellInterval* row = block.intervals;
  for (int32_t z = 0; z < block.cells.z; ++z) {
    for (int32_t y = 0; y < block.cells.y; ++y, row += block.cells.x) {
      const uint64_t bits = VectorOps::active_cells(row, block.cells.x, begin, end);
      mask.row(y, z) = bits;
      count += static_cast<uint32_t>(__builtin_popcountll(bits));
    }
  }
  return count;
}

/// Calls f(y, z, neighbours) for each row that has points, in coding order. Energies are those of
/// the planes z and z − 1 only.
template <class F>
void ChunkEncoder::Scratch::for_each_row(Index3 cells, F f) {
  const PointPlane nothing = {};
  RowPointers last{first_value.at + kRowPad, first_energy.at + kRowPad};
  EnergyRow carried;
  for (int32_t z = 0; z <= cells.z; ++z) {
    bool any = false;
    for (int32_t y = 0; y <= cells.y; ++y) {
      if (!plane[z].points[y].any()) continue;
      const auto row = [&](int back, int32_t row_y) {
        return RowPointers{value[z - back][row_y].at + kRowPad,
                           energy[(z - back) & 1][row_y].at + kRowPad};
      };
      f(y, z, neighbours_of(plane[z], z > 0 ? plane[z - 1] : nothing, y, cells.y, row, last));
      last = row(0, y);
      any = true;
    }
    // The energies of this plane make room for those of the next but one.
    if (any) {
      carried = *reinterpret_cast<const EnergyRow*>(last.energy - kRowPad);
      last.energy = carried.at + kRowPad;
    }
  }
}

void ChunkEncoder::Scratch::set_values(const BlockView& block, ChunkHeader& header) {
  const Index3 cells = block.cells;
  uint32_t all = 0;
  for_each_row(cells, [&](int32_t y, int32_t z, const Neighbours& neighbours) {
    int16_t* row = value[z][y].at + kRowPad;
    fill_values(neighbours, row);
    const Code* voxels = block.voxels + (size_t(z) * (cells.y + 1) + y) * (cells.x + 1);
    for (int word = 0; word < 2; ++word) {
      for (uint64_t bits = plane[z].points[y].word[word]; bits; bits &= bits - 1) {
        const int x = 64 * word + __builtin_ctzll(bits);
        row[x] = static_cast<int16_t>(voxels[x] ^ 0x8000);
        all |= voxels[x];
      }
    }
    pad_row(row, cells.x);
  });
  header.wide = all > 255;
}

void ChunkEncoder::Scratch::fit_predictor(const BlockView& block, uint32_t points,
                                          ChunkHeader& header) {
  const uint32_t stride = std::max(1u, points / kFitSamples);
  uint32_t skip = stride / 2;
  fit.clear();
  const PointPlane nothing = {};
  for_each_row(block.cells, [&](int32_t y, int32_t z, const Neighbours& n) {
    const uint32_t in_row = plane[z].points[y].count();
    if (skip >= in_row) {
      skip -= in_row;
      return;
    }
    const int16_t* row = value[z][y].at + kRowPad;
    for (int word = 0; word < 2; ++word) {
      const ClassBits classes = class_bits(plane[z], z > 0 ? plane[z - 1] : nothing, y, word);
      for (uint64_t bits = plane[z].points[y].word[word]; bits; bits &= bits - 1) {
        if (skip--) continue;
        skip = stride - 1;
        const int bit = __builtin_ctzll(bits), x = 64 * word + bit;
        const int16_t *up = n.up.value + x, *back = n.back.value + x;
        const int16_t *down = n.back_down.value + x, *corner = n.back_up.value + x;
        const int32_t taps[kTaps] = {up[-1],    up[0],     up[1],      back[-1],  back[0],
                                     back[1],   down[-1],  down[0],    down[1],   corner[-1],
                                     corner[0], corner[1], row[x - 1], row[x - 2]};
        fit.add(classes.at(bit), taps, row[x]);
      }
    }
  });
  const PredictorFit::Weights weights = fit.solve(stride);
  header.fitted = weights.fitted;
  std::copy_n(&weights.taps[0][0], kClasses * kTaps, &header.taps[0][0]);
}

void ChunkEncoder::Scratch::set_residuals(const BlockView& block, const ChunkHeader& header) {
  const Index3 cells = block.cells;
  Predictor predictor;
  predictor.greatest = header.wide ? 32767 : 255 - 32768;
  for (int c = 0; c < kClasses; ++c) predictor.classes[c].set(header.taps[c]);
  const auto add = [&](int32_t residual, int32_t group, int32_t octave) {
    residuals.push_back(fold(residual) | static_cast<uint32_t>(octave) << 18 |
                        static_cast<uint32_t>(group) << 24);
  };

  residuals.clear();
  const PointPlane nothing = {};
  int32_t interval_z = 0;  // intervals of slice z come after the points of plane z + 1
  int32_t interval_energy = 0;
  const auto add_intervals = [&](int32_t end_z) {
    for (; block.has_intervals && interval_z < end_z; ++interval_z) {
      const int32_t z = interval_z;
      for (int32_t y = 0; y < cells.y; ++y) {
        for (uint64_t bits = mask.row(y, z); bits; bits &= bits - 1) {
          const int x = __builtin_ctzll(bits);
          const CellInterval range = corner_interval(ScalarOps::corners(
              value[z][y].at + kRowPad + x, value[z][y + 1].at + kRowPad + x,
              value[z + 1][y].at + kRowPad + x, value[z + 1][y + 1].at + kRowPad + x));
          const CellInterval interval = block.intervals[(size_t(z) * cells.y + y) * cells.x + x];
          const int32_t octave =
              half_octave(static_cast<uint32_t>(interval_energy_of(range, interval_energy)));
          const int32_t below = range.min - interval.min, beyond = interval.max - range.max;
          add(below, kIntervalMin, octave);
          add(beyond, kIntervalMax, octave);
          interval_energy = std::min(std::abs(below) + std::abs(beyond), 65535);
        }
      }
    }
  };

  for_each_row(cells, [&](int32_t y, int32_t z, const Neighbours& n) {
    add_intervals(z - 1);
    int16_t* energies = energy[z & 1][y].at + kRowPad;
    fill_energies(n, energies);
    const int16_t* row = value[z][y].at + kRowPad;
    for (int word = 0; word < 2; ++word) {
      const ClassBits classes = class_bits(plane[z], z > 0 ? plane[z - 1] : nothing, y, word);
      for (uint64_t bits = plane[z].points[y].word[word]; bits; bits &= bits - 1) {
        const int bit = __builtin_ctzll(bits), x = 64 * word + bit;
        const uint32_t point_class = classes.at(bit);
        const ClassWeights& weights = predictor.classes[point_class];
        const Sums sums = VectorOps::sum_taps(taps_at(n, x), weights.rows);
        const int32_t residual = row[x] - predictor.predict(weights, sums.prediction, row + x);
        add(residual, group_of_class(point_class), half_octave(static_cast<uint32_t>(sums.energy)));
        energies[x] = static_cast<int16_t>(std::min(std::abs(residual), kMaxEnergy));
      }
    }
    pad_row(energies, cells.x);
  });
  add_intervals(cells.z);
}

/// Chooses where levels begin, and each context's model: the shift by the mean, the shape by its
/// cost. Replaces the half octave and group of each residual by its context << 24.
void ChunkEncoder::Scratch::choose_models(ChunkHeader& header) {
  std::array<uint32_t, 64> octaves{};
  for (const uint32_t r : residuals) ++octaves[r >> 18 & 63];
  const size_t few = residuals.size() / 16;
  size_t below = 0;
  header.levels.base = 0;
  while (header.levels.base < 15 && (below += octaves[header.levels.base]) <= few) {
    ++header.levels.base;
  }

  std::array<uint64_t, kContexts> sum{};
  std::array<uint32_t, kContexts> count{};
  for (uint32_t& r : residuals) {
    const auto octave = static_cast<int32_t>(r >> 18 & 63), group = static_cast<int32_t>(r >> 24);
    const auto context =
        static_cast<uint32_t>(group * kLevels + header.levels.level_of_octave(octave));
    r = (r & 0x3ffff) | context << 24;
    sum[context] += r & 0x3ffff;
    ++count[context];
  }
  std::array<uint32_t, kContexts> shift{};
  for (int c = 0; c < kContexts; ++c) {
    while (shift[c] < kMaxShift && sum[c] * 8 > uint64_t{count[c]} * 72 << shift[c]) ++shift[c];
  }
  std::array<std::array<uint32_t, kTokens>, kContexts> histogram{};
  for (const uint32_t r : residuals) {
    const uint32_t c = r >> 24;
    ++histogram[c][token_of((r & 0x3ffff) >> shift[c]).token];
  }
  for (int c = 0; c < kContexts; ++c) {
    header.model[c] = kNoModel;
    uint64_t best = ~uint64_t{0};
    for (uint32_t m = 0; m < kModels && count[c]; ++m) {
      const Model model = model_of(m);
      if (model.shift != shift[c]) continue;
      uint64_t cost = 0;
      for (int t = 0; t < kTokens; ++t) {
        cost += uint64_t{histogram[c][t]} * token_cost[model.shape][t];
      }
      if (cost < best) best = cost, header.model[c] = static_cast<uint8_t>(m);
    }
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

  s.rans.clear();
  BrickMask bricks = bricks_of(s.mask, block.cells);
  MaskEncoder mask_encoder{s.quad_starts, s.rans};
  code_mask(block.cells, bricks, s.mask, mask_encoder);

  uint32_t points = 0;
  for (int32_t z = 0; z <= block.cells.z; ++z) points += s.plane[z].set(s.mask, block.cells, z);
  set_first_row(slab_begin, slab_end, s.first_value, s.first_energy);

  ChunkHeader header;
  s.set_values(block, header);
  s.fit_predictor(block, points, header);
  for (const uint32_t below : kMergeBelow) header.levels.merge += points < below;
  s.set_residuals(block, header);
  s.choose_models(header);

  s.bit_writer.clear();
  write_header(header, block.has_intervals, s.bit_writer);
  std::array<Model, kContexts> models{};
  for (int c = 0; c < kContexts; ++c) {
    if (header.model[c] != kNoModel) models[c] = model_of(header.model[c]);
  }
  for (const uint32_t r : s.residuals) {
    const Model model = models[r >> 24];
    const uint32_t folded = r & 0x3ffff;
    const Token token = token_of(folded >> model.shift);
    s.rans.put(s.token_start[model.shape][token.token], kTokenShapes[model.shape][token.token], 11);
    const uint32_t raw_bits = token.raw_bits + model.shift;
    s.bit_writer.put(folded & ((1u << raw_bits) - 1), static_cast<int>(raw_bits));
  }
  s.rans.finish(out);
  s.bit_writer.finish(out);
  return count;
}

}  // namespace isosplat
