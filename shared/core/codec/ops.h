#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "shared/core/codec/bit_positions.h"
#include "shared/core/codec/simd_widest.h"
#include "shared/core/sampling/cell.h"

/// The codec's inner operations. ScalarOps defines them; VectorOps gives the same results bit for
/// bit with vectors (SSE4.1, AVX2, WASM SIMD) if the target has them.
namespace isosplat {

/// The neighbours of point x in four other rows. Each pointer points at position x − 1, and four
/// values are read: x − 1, x, x + 1, and x + 2 with weight 0.
struct TapPointers {
  const int16_t* up;
  const int16_t* back;
  const int16_t* back_down;
  const int16_t* back_up;
};

/// An energy on a logarithmic scale of half octaves. Less than kOctaves if the energy is less than
/// 2^20.
inline constexpr int kOctaves = 40;
inline int32_t half_octave(uint32_t energy) {
  const uint32_t e = energy + 2;
  const int32_t bits = 31 - __builtin_clz(e);
  return 2 * bits + static_cast<int32_t>(e >> (bits - 1) & 1) - 2;
}
/// half_octave(plus_two − 2) for a number below 2^24, in a form that compilers vectorise: it uses
/// the exponent of a float, because not all instruction sets count leading zeros of vectors.
inline int32_t half_octave_by_float(int32_t plus_two) {
  const auto number = static_cast<float>(plus_two);
  uint32_t bits;
  std::memcpy(&bits, &number, sizeof bits);
  return static_cast<int32_t>(bits >> 22) - 256;
}

/// The energies of three adjacent rows. Each pointer points at position −1.
struct EnergyRows {
  const int16_t *above, *here, *below;

  /// The weighted sum of the nine energies around x: 1 2 1, 2 4 2, 1 2 1. At most 16 · kMaxEnergy.
  uint32_t around(int32_t x) const {
    const auto column = [&](int32_t i) { return above[i] + 2 * here[i] + below[i]; };
    return static_cast<uint32_t>(column(x) + 2 * column(x + 1) + column(x + 2));
  }
};

/// The class of a point: bit i is bit `bit` of words[i].
inline uint32_t class_at(const uint64_t* words, int bit) {
  uint32_t point_class = 0;
  for (int i = 0; i < 4; ++i) point_class |= static_cast<uint32_t>(words[i] >> bit & 1) << i;
  return point_class;
}

/// The position of the n-th set bit of a word, counted from 0. Requires more than n set bits.
inline int nth_bit(uint64_t word, uint32_t n) {
#if defined(__BMI2__)
  return __builtin_ctzll(_pdep_u64(uint64_t{1} << n, word));
#else
  while (n--) word &= word - 1;
  return __builtin_ctzll(word);
#endif
}

/// The neighbours and weights of the prediction of a point: four weights for each row of taps. The
/// fourth weight belongs to *left in the row `up`, and is zero in the other rows.
struct WeightedTaps {
  TapPointers taps;
  const int16_t* left;
  const int16_t* weights;
};

struct ScalarOps {
  /// The last quad whose start is ≤ slot. starts: 16, ascending, the first 0.
  static uint32_t find_quad(const uint16_t* starts, uint32_t slot) {
    uint32_t quad = 0;
    for (int i = 1; i < 16; ++i) quad += starts[i] <= slot;
    return quad;
  }

  /// The weighted sum of a point's taps.
  static int32_t sum_taps(const WeightedTaps& point) {
    const auto& [taps, left, weights] = point;
    int32_t sum = *left * weights[3];
    for (int i = 0; i < 3; ++i) {
      sum += taps.up[i] * weights[i] + taps.back[i] * weights[4 + i] +
             taps.back_down[i] * weights[8 + i] + taps.back_up[i] * weights[12 + i];
    }
    return sum;
  }

  /// sum_taps() of four points; of(i) returns the WeightedTaps of point i.
  template <class F>
  static void sum_four(F of, int32_t* sums) {
    for (int i = 0; i < 4; ++i) sums[i] = sum_taps(of(i));
  }

  /// Sets values[x] to quantized_values[x] − 32768 for each bit x that is set in `points`. A row
  /// has `count` values (at most 64). Returns the bitwise OR of the quantized values used.
  static uint32_t set_points(uint64_t points, const QuantizedValue* quantized_values,
                             [[maybe_unused]] int32_t count, int16_t* values) {
    uint32_t all = 0;
    for (; points; points &= points - 1) {
      const int x = __builtin_ctzll(points);
      values[x] = static_cast<int16_t>(quantized_values[x] ^ 0x8000);
      all |= quantized_values[x];
    }
    return all;
  }

  /// Lists the points of a row from their bits, ascending: x, class, and half_octave() of the
  /// energies around each. Returns their number. May overwrite 8 bytes after the last entry of each
  /// list. class_words: see class_at().
  static int32_t list_points(uint64_t points, const uint64_t* class_words,
                             const EnergyRows& energies, uint8_t* x, uint8_t* point_class,
                             uint8_t* octave) {
    int32_t count = 0;
    for (; points; points &= points - 1, ++count) {
      const int bit = __builtin_ctzll(points);
      x[count] = static_cast<uint8_t>(bit);
      point_class[count] = static_cast<uint8_t>(class_at(class_words, bit));
      octave[count] = static_cast<uint8_t>(half_octave(energies.around(bit)));
    }
    return count;
  }

  /// Bit i is set if max(min, begin) < min(max, end) for cell i. count ≤ 64.
  static uint64_t active_cells(const CellInterval* cells, int32_t count, uint32_t begin,
                               uint32_t end) {
    uint64_t bits = 0;
    for (int32_t i = 0; i < count; ++i) {
      const bool active =
          std::max<uint32_t>(cells[i].min, begin) < std::min<uint32_t>(cells[i].max, end);
      bits |= static_cast<uint64_t>(active) << i;
    }
    return bits;
  }
};

#if ISOSPLAT_CODEC_SIMD

/// For each of 16 bits: the byte that contains it, and its value in that byte.
alignas(16) inline constexpr uint8_t kByteOfBit[16] = {0, 0, 0, 0, 0, 0, 0, 0,
                                                       1, 1, 1, 1, 1, 1, 1, 1};
alignas(16) inline constexpr uint8_t kBitOfByte[16] = {1, 2, 4, 8, 16, 32, 64, 128,
                                                       1, 2, 4, 8, 16, 32, 64, 128};

alignas(16) inline constexpr uint16_t kBitOfLane[8] = {1, 2, 4, 8, 16, 32, 64, 128};

/// half_octave(energies.around(x)) in 16-bit lanes: `x` in the first, x + 1 in the next, and so on.
template <class T>
[[gnu::always_inline]] inline T half_octaves(const EnergyRows& energies, int32_t x) {
  using namespace simd;
  const auto column = [&](int32_t at) {
    const T middle = load_as<T>(energies.here + at);
    const T others = add16(load_as<T>(energies.above + at), load_as<T>(energies.below + at));
    return add16(others, add16(middle, middle));
  };
  const T middle = column(x + 1), zero = splat16_as<T>(0);
  const T sums = add16(add16(column(x), column(x + 2)), add16(middle, middle));
  const T plus_two = add16(sums, splat16_as<T>(2));
  const T octaves = narrow32(float_bits(low_halves16(plus_two, zero), 22),
                             float_bits(high_halves16(plus_two, zero), 22));
  return sub16(octaves, splat16_as<T>(256));
}

struct VectorOps {
  static uint32_t find_quad(const uint16_t* starts, uint32_t slot) {
    using namespace simd;
#if defined(__AVX2__)
    const W beyond = greater_s16(load_as<W>(starts), splat16_as<W>(slot));
    return 15 - static_cast<uint32_t>(__builtin_popcount(sign_bits8(beyond))) / 2;
#else
    const V s = splat16(slot);
    const V beyond = narrow_s(greater_s16(load(starts), s), greater_s16(load(starts + 8), s));
    return 15 - static_cast<uint32_t>(__builtin_popcount(sign_bits8(beyond)));
#endif
  }

  template <class F>
  static void sum_four(F of, int32_t* sums) {
    using namespace simd;
    V rows[4];
    for (int i = 0; i < 4; ++i) {
      const auto [taps, left, weights] = of(i);
      const V near = multiply_add_pairs(load_lane16<3>(load_two_halves(taps.up, taps.back), left),
                                        load(weights));
      const V far =
          multiply_add_pairs(load_two_halves(taps.back_down, taps.back_up), load(weights + 8));
      rows[i] = add32(near, far);
    }
    store(sums, sum_each(rows[0], rows[1], rows[2], rows[3]));
  }

  static uint32_t set_points(uint64_t points, const QuantizedValue* quantized_values, int32_t count,
                             int16_t* values) {
    using namespace simd;
    const V bits = load(kBitOfLane), sign = splat16(0x8000);
    V all = splat16(0);
    int32_t x = 0;
    for (; x + 8 <= count; x += 8) {
      const V set = equal16(and_(splat16(static_cast<uint32_t>(points >> x & 255)), bits), bits);
      const V quantized = and_(load(quantized_values + x), set);
      store(values + x, select(load(values + x), xor_(quantized, sign), set));
      all = or_(all, quantized);
    }
    uint64_t halves[2];
    store(halves, all);
    uint64_t both = halves[0] | halves[1];
    both |= both >> 32;
    const auto here = static_cast<uint32_t>((both | both >> 16) & 0xffff);
    if (x >= 64) return here;
    return here | ScalarOps::set_points(points >> x, quantized_values + x, count - x, values + x);
  }

  static int32_t list_points(uint64_t points, const uint64_t* class_words,
                             const EnergyRows& energies, uint8_t* x, uint8_t* point_class,
                             uint8_t* octave) {
    using namespace simd;
    const V bits = load(kBitOfByte), byte_of_bit = load(kByteOfBit);
    int32_t count = 0;
    for (int32_t at = 0; at < 64; at += 16) {
      if (!(points >> at & 0xffff)) continue;
      V classes = splat8(0);
      for (int i = 0; i < 4; ++i) {
        const V word = splat32(static_cast<uint32_t>(class_words[i] >> at));
        const V set = equal8(and_(shuffle8(word, byte_of_bit), bits), bits);
        classes = or_(classes, and_(set, splat8(1u << i)));
      }
#if defined(__AVX2__)
      const V octaves = narrow_u_halves(half_octaves<W>(energies, at));
#else
      const V octaves = narrow_u(half_octaves<V>(energies, at), half_octaves<V>(energies, at + 8));
#endif
      for (int half = 0; half < 2; ++half) {
        const uint32_t byte = points >> (at + 8 * half) & 255;
        const V from = add8(load_half(kBitPositions.of[byte]), splat8(half ? 8 : 0));
        store_half(x + count, add8(from, splat8(static_cast<uint32_t>(at))));
        store_half(point_class + count, shuffle8(classes, from));
        store_half(octave + count, shuffle8(octaves, from));
        count += __builtin_popcount(byte);
      }
    }
    return count;
  }

  static uint64_t active_cells(const CellInterval* cells, int32_t count, uint32_t begin,
                               uint32_t end) {
    using namespace simd;
    static_assert(sizeof(CellInterval) == 4);
    // In each lane, the lower 16 bits are max(min, begin), and the upper ones min(max, end). An end
    // of 65536 may count as 65535, because no cell's max exceeds 65535.
    const uint32_t low_bound = begin, high_bound = 0xffff | std::min(end, 65535u) << 16;
    uint64_t bits = 0;
    int32_t i = 0;
#if defined(__AVX2__)
    const __m256i low8 = _mm256_set1_epi32(static_cast<int32_t>(low_bound));
    const __m256i high8 = _mm256_set1_epi32(static_cast<int32_t>(high_bound));
    for (; i + 8 <= count; i += 8) {
      const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(cells + i));
      const __m256i clipped = _mm256_min_epu16(_mm256_max_epu16(all, low8), high8);
      const __m256i active = _mm256_cmpgt_epi32(
          _mm256_srli_epi32(clipped, 16), _mm256_and_si256(clipped, _mm256_set1_epi32(0xffff)));
      bits |= static_cast<uint64_t>(_mm256_movemask_ps(_mm256_castsi256_ps(active))) << i;
    }
#endif
    const V low = splat32(low_bound), high = splat32(high_bound);
    for (; i + 4 <= count; i += 4) {
      const V clipped = min_u16(max_u16(load(cells + i), low), high);
      const V active = greater_s32(high_halves(clipped), and_(clipped, splat32(0xffff)));
      bits |= static_cast<uint64_t>(sign_bits32(active)) << i;
    }
    if (i < count) bits |= ScalarOps::active_cells(cells + i, count - i, begin, end) << i;
    return bits;
  }
};
#else
using VectorOps = ScalarOps;
#endif

}  // namespace isosplat
