#include "shared/core/codec/plane_residuals.h"

#include "shared/core/codec/residual_model.h"

namespace isosplat {

void PlaneResiduals::add_row(const PointPlane& current, const PointPlane& previous, int32_t y,
                             const Neighbours& n, const Row& row) {
  rows_[y] = {n, row.value + kRowPad};
  add_word(current, previous, y, 0);
  if (current.points[y].has(kBlockCells)) add_word(current, previous, y, 1);
}

/// Adds the windows of positions 64 · word to 64 · word + 63 of a row.
void PlaneResiduals::add_word(const PointPlane& current, const PointPlane& previous, int32_t y,
                              int word) {
  const uint64_t points = current.points[y].word[word];
  const ClassBits classes = class_bits(current, previous, y, word);
  const uint64_t exposed = ~(classes.words[1] & classes.words[2]);
  const uint64_t others = points & (exposed | ~(classes.words[0] & classes.words[3]));
  int32_t window_of[kBlockCells / kLanes];
  for (int32_t part = 0; part < kBlockCells / kLanes; ++part) {
    const auto lanes = [&](uint64_t bits) {
      return static_cast<uint16_t>(bits >> part * kLanes & ((1u << kLanes) - 1));
    };
    // Branch prediction fails here, because windows with and without points alternate irregularly:
    // a window is always written, and kept if it has points.
    window_[windows_] = {static_cast<uint8_t>(64 * word + part * kLanes), static_cast<uint8_t>(y),
                         lanes(points), lanes(others), lanes(exposed)};
    window_of[part] = windows_;
    windows_ += lanes(points) != 0;
  }
  for (uint64_t bits = others; bits; bits &= bits - 1) {
    const int bit = __builtin_ctzll(bits);
    other_[others_++] = {static_cast<uint8_t>(64 * word + bit), static_cast<uint8_t>(y),
                         static_cast<uint8_t>(class_at(classes.words, bit)),
                         static_cast<uint16_t>(kLanes * window_of[bit / kLanes] + bit % kLanes)};
  }
}

void PlaneResiduals::predict_others() {
  // Four points at a time: copies of the last point fill up the last four.
  for (int32_t i = others_; i < others_ + 3; ++i) other_[i] = other_[others_ > 0 ? others_ - 1 : 0];
  for (int32_t i = 0; i < others_; i += 4) {
    int32_t sums[4];
    VectorOps::sum_four(
        [&](int k) {
          const Other& other = other_[i + k];
          const auto& row = rows_[other.y];
          return WeightedTaps{taps_at(row.neighbours, other.x), row.values + other.x - 1,
                              predictor_.classes[other.point_class].rows};
        },
        sums);
    for (int k = 0; k < 4; ++k) {
      const Other& other = other_[i + k];
      prediction_[other.lane] = static_cast<int16_t>(predictor_.predict(
          predictor_.classes[other.point_class], sums[k], rows_[other.y].values + other.x));
    }
  }
}

#if ISOSPLAT_CODEC_SIMD
namespace {

using simd::Widest;

/// Lanes of all ones where a bit is set, and zero elsewhere.
Widest lanes_of(uint32_t bits) {
  using namespace simd;
  alignas(32) static constexpr uint16_t kBits[16] = {
      1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
  const auto lanes = load_as<Widest>(kBits);
  return equal16(and_(splat16_as<Widest>(bits), lanes), lanes);
}

/// Predicts adjacent points that have the same class.
class ClassPredictor {
 public:
  ClassPredictor(const ClassWeights& weights, int32_t greatest)
      : greatest_(simd::splat16_as<Widest>(static_cast<uint16_t>(greatest))) {
    const auto both = [](int16_t a, int16_t b) {
      return simd::splat32_as<Widest>(static_cast<uint16_t>(a) | static_cast<uint32_t>(b) << 16);
    };
    const int16_t* const w = weights.rows;
    for (int row = 0; row < 4; ++row) weights_[row] = both(w[4 * row], w[4 * row + 1]);
    weights_[4] = both(w[2], w[6]);
    weights_[5] = both(w[10], w[14]);
    weights_[6] = both(weights.own[0], weights.own[1]);
  }

  /// row: the values of the points' own row, from the first point on.
  Widest predict(const TapPointers& taps, const int16_t* row) const {
    using namespace simd;
    // Each multiply_add_pairs() handles two taps.
    const int16_t* const first[] = {taps.up,     taps.back,          taps.back_down, taps.back_up,
                                    taps.up + 2, taps.back_down + 2, row - 2};
    const int16_t* const second[] = {taps.up + 1,      taps.back + 1, taps.back_down + 1,
                                     taps.back_up + 1, taps.back + 2, taps.back_up + 2,
                                     row - 1};
    Widest low = splat32_as<Widest>(1 << (kWeightBits - 1)), high = low;
    for (int i = 0; i < 7; ++i) {
      const auto a = load_as<Widest>(first[i]), b = load_as<Widest>(second[i]);
      low = add32(low, multiply_add_pairs(low_halves16(a, b), weights_[i]));
      high = add32(high, multiply_add_pairs(high_halves16(a, b), weights_[i]));
    }
    // Signed saturation keeps predictions above −32768.
    return min_s16(narrow32(shift_right_s32(low, kWeightBits), shift_right_s32(high, kWeightBits)),
                   greatest_);
  }

 private:
  Widest weights_[7];
  Widest greatest_;
};

/// fold() of each lane.
Widest fold_lanes(Widest residual) {
  using namespace simd;
  const Widest less = add32(residual, splat32_as<Widest>(~0u));
  return xor_(add32(residual, less), shift_right_s32(less, 31));
}

}  // namespace

/// Computes the keys of all points, before put() changes any energy.
void PlaneResiduals::find_keys(const Energies& energies) {
  using namespace simd;
  for (int32_t i = 0; i < windows_; ++i) {
    const Window window = window_[i];
    const auto octave = half_octaves<Widest>(energies.around(window.y), window.x);
    const Widest group = and_(lanes_of(window.exposed), splat16_as<Widest>(kOctaves));
    store(key_ + kLanes * i, add16(octave, group));
  }
}

uint32_t* PlaneResiduals::put(Energies& energies, uint32_t* to) {
  using namespace simd;
  find_keys(energies);
  predict_others();
  const ClassPredictor whole(predictor_.classes[kWhole], predictor_.greatest);
  const auto sign = splat16_as<Widest>(0x8000), zero = splat16_as<Widest>(0);
  const auto most = splat16_as<Widest>(kMaxEnergy);
  const auto least = splat16_as<Widest>(static_cast<uint16_t>(-kMaxEnergy));
  for (int32_t i = 0; i < windows_; ++i) {
    const Window window = window_[i];
    const auto& row = rows_[window.y];
    const int16_t* const values = row.values + window.x;
    const Widest prediction =
        xor_(select(whole.predict(taps_at(row.neighbours, window.x), values),
                    load_as<Widest>(prediction_ + kLanes * i), lanes_of(window.others)),
             sign);
    const Widest value = xor_(load_as<Widest>(values), sign);
    const Widest low = sub32(low_halves16(value, zero), low_halves16(prediction, zero));
    const Widest high = sub32(high_halves16(value, zero), high_halves16(prediction, zero));

    const Widest clipped = max_s16(narrow32(low, high), least);
    const Widest energy = min_s16(max_s16(clipped, sub16(zero, clipped)), most);
    int16_t* const energies_here = &energies.values[window.y + 1][window.x + 1];
    store(energies_here, select(load_as<Widest>(energies_here), energy, lanes_of(window.points)));

    const Widest key = shift_left_u16(load_as<Widest>(key_ + kLanes * i), kFoldedBits - 16);
    to = store_present(to, or_(fold_lanes(low), low_halves16(zero, key)),
                       or_(fold_lanes(high), high_halves16(zero, key)), window.points);
  }
  return to;
}
#else
void PlaneResiduals::find_keys(const Energies& energies) {
  for (int32_t i = 0; i < windows_; ++i) {
    const Window window = window_[i];
    for (uint32_t bits = window.points; bits; bits &= bits - 1) {
      const int bit = __builtin_ctz(bits);
      const bool exposed = window.exposed >> bit & 1;
      key_[kLanes * i + bit] = static_cast<int16_t>(
          residual_key(half_octave(energies.around(window.y).around(window.x + bit)),
                       exposed ? kExposed : kEnclosed));
    }
  }
}

uint32_t* PlaneResiduals::put(Energies& energies, uint32_t* to) {
  find_keys(energies);
  predict_others();
  const ClassWeights& whole = predictor_.classes[kWhole];
  for (int32_t i = 0; i < windows_; ++i) {
    const Window window = window_[i];
    const auto& row = rows_[window.y];
    for (uint32_t bits = window.points; bits; bits &= bits - 1) {
      const int bit = __builtin_ctz(bits), x = window.x + bit;
      int32_t prediction = prediction_[kLanes * i + bit];
      if (!(window.others >> bit & 1)) {
        const int32_t sum =
            ScalarOps::sum_taps({taps_at(row.neighbours, x), row.values + x - 1, whole.rows});
        prediction = predictor_.predict(whole, sum, row.values + x);
      }
      const int32_t residual = row.values[x] - prediction;
      energies.set(x, window.y, residual);
      *to++ = residual_entry(fold(residual), key_[kLanes * i + bit]);
    }
  }
  return to;
}
#endif

}  // namespace isosplat
