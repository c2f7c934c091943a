#include "shared/core/codec/chunk_codec.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "shared/core/codec/cell_mask.h"
#include "shared/core/codec/lattice.h"
#include "shared/core/codec/ops.h"
#include "shared/core/codec/pack_cells.h"
#include "shared/core/points/field_samples.h"

namespace isosplat {
namespace {

/// Random numbers that are the same with every standard library.
struct Random {
  uint32_t state;
  uint32_t operator()() {
    state = state * 1664525 + 1013904223;
    return state >> 8;
  }
};

struct Block {
  Index3 cells;
  std::vector<QuantizedValue> voxels;
  std::vector<CellInterval> intervals;
  bool has_intervals = false;

  BlockVoxels view() const { return {cells, voxels.data(), intervals.data(), has_intervals}; }

  CellCorners corners(Index3 p) const {
    CellCorners result;
    for (int i = 0; i < 8; ++i) {
      const int32_t x = p.x + (i & 1), y = p.y + (i >> 1 & 1), z = p.z + (i >> 2 & 1);
      result[i] = voxels[(size_t(z) * (cells.y + 1) + y) * (cells.x + 1) + x];
    }
    return result;
  }
};

enum class Kind { constant, noise, smooth, steps };

Block make_block(Index3 cells, Kind kind, uint32_t largest, bool widened, uint32_t seed) {
  Random random{seed};
  Block block{cells, {}, {}, widened};
  for (int32_t z = 0; z <= cells.z; ++z) {
    for (int32_t y = 0; y <= cells.y; ++y) {
      for (int32_t x = 0; x <= cells.x; ++x) {
        const uint32_t noise = random();
        uint32_t value = largest / 2;
        if (kind == Kind::noise) value = noise % (largest + 1);
        if (kind == Kind::smooth) {
          value = uint32_t(x * x + 3 * y * z + 5 * y + int32_t(seed)) * largest / 16000 + noise % 3;
        }
        if (kind == Kind::steps) value = (x + y * 2 + z) % 19 < 9 ? largest / 5 : largest;
        block.voxels.push_back(QuantizedValue(std::min(value, largest)));
      }
    }
  }
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      for (int32_t x = 0; x < cells.x; ++x) {
        CellInterval interval = corner_interval(block.corners({x, y, z}));
        if (widened) {
          interval.min =
              QuantizedValue(interval.min - std::min<uint32_t>(interval.min, random() % 9));
          interval.max = QuantizedValue(std::min<uint32_t>(largest, interval.max + random() % 9));
        }
        block.intervals.push_back(interval);
      }
    }
  }
  return block;
}

void expect_round_trip(const Block& block, uint32_t begin, uint32_t end, ChunkEncoder& encoder,
                       ChunkDecoder& decoder) {
  std::vector<std::byte> bytes;
  const uint32_t count = encoder.encode(block.view(), begin, end, bytes);

  DecodedCells expected;
  std::vector<PackedSample> expected_packed;
  size_t i = 0;
  for (int32_t z = 0; z < block.cells.z; ++z) {
    for (int32_t y = 0; y < block.cells.y; ++y) {
      for (int32_t x = 0; x < block.cells.x; ++x, ++i) {
        const CellInterval interval = block.intervals[i];
        if (std::max<uint32_t>(interval.min, begin) >= std::min<uint32_t>(interval.max, end)) {
          continue;
        }
        expected.cell.push_back(uint32_t(x | y << 6 | z << 12));
        expected.corners.push_back(block.corners({x, y, z}));
        expected.interval.push_back(interval);
        expected_packed.push_back(pack_sample({x, y, z}, interval, block.corners({x, y, z})));
      }
    }
  }
  ASSERT_EQ(count, expected.cell.size());
  if (!count) {
    ASSERT_TRUE(bytes.empty());
    return;
  }
  const ChunkShape shape{block.cells, begin, end, count, block.has_intervals};
  DecodedCells cells;
  const auto done = decoder.decode(bytes, shape, cells);
  ASSERT_TRUE(done) << done.error().message;
  ASSERT_EQ(cells.cell, expected.cell);
  ASSERT_EQ(cells.corners, expected.corners);
  ASSERT_EQ(cells.interval, expected.interval);
  std::vector<PackedSample> packed;
  ASSERT_TRUE(decoder.decode_packed(bytes, shape, packed));
  ASSERT_EQ(packed, expected_packed);
}

TEST(ChunkCodec, RoundTripsBlocksOfEveryShape) {
  ChunkEncoder encoder;
  ChunkDecoder decoder;
  uint32_t seed = 1;
  for (const Index3 cells : {Index3{1, 1, 1},
                             {2, 1, 1},
                             {1, 2, 1},
                             {1, 1, 2},
                             {3, 5, 7},
                             {64, 1, 1},
                             {1, 64, 1},
                             {1, 1, 64},
                             {64, 64, 1},
                             {63, 2, 31},
                             {16, 16, 16},
                             {64, 64, 64}}) {
    for (const Kind kind : {Kind::constant, Kind::noise, Kind::smooth, Kind::steps}) {
      for (const uint32_t largest : {1u, 255u, 4095u, 65535u}) {
        for (const bool widened : {false, true}) {
          if (cells.x * cells.y * cells.z > 100000 && (largest == 65535 || largest == 1)) continue;
          const Block block = make_block(cells, kind, largest, widened, ++seed);
          for (const auto& [begin, end] :
               {std::pair{0u, 65536u}, std::pair{0u, 1u}, std::pair{largest / 3, largest / 3 + 1},
                std::pair{largest / 4, largest / 2 + 1}, std::pair{largest / 2, 65536u}}) {
            SCOPED_TRACE(testing::Message()
                         << cells.x << "x" << cells.y << "x" << cells.z << " kind " << int(kind)
                         << " largest " << largest << " widened " << widened << " band " << begin
                         << ".." << end << " seed " << seed);
            expect_round_trip(block, begin, end, encoder, decoder);
            if (HasFatalFailure()) return;
          }
        }
      }
    }
  }
}

/// Small chunks of every kind: smooth and rough, narrow and wide quantized values, both kinds of
/// level.
struct SmallChunk {
  ChunkShape shape;
  std::vector<std::byte> bytes;
};
std::vector<SmallChunk> small_chunks() {
  std::vector<SmallChunk> chunks;
  ChunkEncoder encoder;
  for (const Kind kind : {Kind::noise, Kind::smooth, Kind::steps}) {
    for (const uint32_t largest : {255u, 65535u}) {
      for (const bool widened : {false, true}) {
        const Block block = make_block({11, 9, 6}, kind, largest, widened, largest + widened);
        SmallChunk chunk{{block.cells, largest / 4, largest / 2, 0, widened}, {}};
        chunk.shape.cell_count =
            encoder.encode(block.view(), chunk.shape.band_begin, chunk.shape.band_end, chunk.bytes);
        if (chunk.shape.cell_count > 0) chunks.push_back(chunk);
      }
    }
  }
  return chunks;
}

/// Decodes in both ways, which must agree, and returns the status.
Status decode_both(ChunkDecoder& decoder, std::span<const std::byte> bytes,
                   const ChunkShape& shape) {
  DecodedCells cells;
  std::vector<PackedSample> packed;
  const auto plain = decoder.decode(bytes, shape, cells);
  const auto fast = decoder.decode_packed(bytes, shape, packed);
  EXPECT_EQ(plain.has_value(), fast.has_value());
  if (!plain) {
    EXPECT_FALSE(plain.error().message.empty());
    EXPECT_EQ(plain.error().status, fast.error().status);
    return plain.error().status;
  }
  EXPECT_EQ(cells.cell.size(), shape.cell_count);
  EXPECT_EQ(packed.size(), shape.cell_count);
  for (size_t i = 0; i < packed.size(); ++i) {
    const uint32_t place = cells.cell[i];
    const Index3 cell{int32_t(place & 63), int32_t(place >> 6 & 63), int32_t(place >> 12)};
    EXPECT_EQ(packed[i], pack_sample(cell, cells.interval[i], cells.corners[i]));
  }
  return Status::ok;
}

TEST(ChunkCodec, RejectsEveryTruncationAndEveryExtraByte) {
  ChunkDecoder decoder;
  for (const SmallChunk& chunk : small_chunks()) {
    ASSERT_EQ(decode_both(decoder, chunk.bytes, chunk.shape), Status::ok);
    for (size_t size = 0; size < chunk.bytes.size(); ++size) {
      const auto first = std::span(chunk.bytes).first(size);
      EXPECT_NE(decode_both(decoder, first, chunk.shape), Status::ok) << size;
    }
    std::vector<std::byte> behind = chunk.bytes;
    behind.push_back(std::byte{0});
    EXPECT_NE(decode_both(decoder, behind, chunk.shape), Status::ok);
    // In other chunks, a byte may happen to be read as part of the header.
    for (size_t at = 0; at < chunk.bytes.size(); ++at) {
      std::vector<std::byte> longer = chunk.bytes;
      longer.insert(longer.begin() + ptrdiff_t(at), std::byte{0});
      decode_both(decoder, longer, chunk.shape);
    }
  }
}

TEST(ChunkCodec, SurvivesEveryFlippedBitAndRandomBytes) {
  ChunkDecoder decoder;
  Random random{7};
  for (SmallChunk& chunk : small_chunks()) {
    for (size_t bit = 0; bit < chunk.bytes.size() * 8; ++bit) {
      chunk.bytes[bit / 8] ^= std::byte(1 << (bit & 7));
      decode_both(decoder, chunk.bytes, chunk.shape);
      chunk.bytes[bit / 8] ^= std::byte(1 << (bit & 7));
    }
    for (int i = 0; i < 200; ++i) {
      std::vector<std::byte> noise = chunk.bytes;
      for (size_t at = random() % noise.size(); at < noise.size(); at += 1 + random() % 9) {
        noise[at] = std::byte(random());
      }
      decode_both(decoder, noise, chunk.shape);
    }
  }
}

TEST(ChunkCodec, RejectsShapesOutsideTheirLimits) {
  ChunkDecoder decoder;
  const std::vector<std::byte> bytes(100);
  for (const ChunkShape& shape : {ChunkShape{{0, 1, 1}, 0, 9, 1, false},
                                  {{65, 1, 1}, 0, 9, 1, false},
                                  {{4, 4, -1}, 0, 9, 1, false},
                                  {{4, 4, 4}, 0, 9, 0, false},
                                  {{4, 4, 4}, 0, 9, 65, false},
                                  {{4, 4, 4}, 9, 9, 1, false},
                                  {{4, 4, 4}, 0, 65537, 1, false}}) {
    EXPECT_EQ(decode_both(decoder, bytes, shape), Status::invalid_argument);
  }
}

TEST(ChunkCodec, RejectsAnotherNumberOfCells) {
  ChunkDecoder decoder;
  for (SmallChunk& chunk : small_chunks()) {
    --chunk.shape.cell_count;
    if (chunk.shape.cell_count == 0) continue;
    EXPECT_EQ(decode_both(decoder, chunk.bytes, chunk.shape), Status::malformed_chunk);
    chunk.shape.cell_count += 2;
    EXPECT_EQ(decode_both(decoder, chunk.bytes, chunk.shape), Status::malformed_chunk);
  }
}

TEST(ChunkCodec, LeavesOutTheBitsThatNoIntervalUses) {
  Block block = make_block({20, 20, 20}, Kind::noise, 4095, true, 3);
  ChunkEncoder encoder;
  ChunkDecoder decoder;
  std::vector<std::byte> exact, rounded;
  encoder.encode(block.view(), 0, 65536, exact);
  for (CellInterval& interval : block.intervals) {
    interval = {QuantizedValue(interval.min & ~15), QuantizedValue(interval.max | 15)};
  }
  encoder.encode(block.view(), 0, 65536, rounded);
  EXPECT_LT(rounded.size() + 8000 * 2 * 3 / 8, exact.size());
  expect_round_trip(block, 0, 65536, encoder, decoder);
}

TEST(ChunkCodec, PacksTheIntervalsOfCornersWhereTheySuffice) {
  ChunkEncoder encoder;
  ChunkDecoder decoder;
  for (const uint32_t largest : {62u, 255u, 4095u}) {
    for (const bool corners_suffice : {false, true}) {
      if (largest > 255 && corners_suffice) continue;  // not allowed
      Block block = make_block({20, 20, 20}, Kind::noise, largest, true, 4);
      for (CellInterval& interval : block.intervals) {
        interval = {QuantizedValue(interval.min & ~127), QuantizedValue(interval.max | 127)};
      }
      BlockVoxels voxels = block.view();
      voxels.corners_suffice = corners_suffice;
      std::vector<std::byte> bytes;
      const uint32_t count = encoder.encode(voxels, 0, 65535, bytes);
      ASSERT_EQ(count, block.intervals.size());
      const ChunkShape shape{block.cells, 0, 65535, count, true};
      DecodedCells cells;
      std::vector<PackedSample> packed;
      ASSERT_TRUE(decoder.decode(bytes, shape, cells));
      ASSERT_TRUE(decoder.decode_packed(bytes, shape, packed));
      ASSERT_EQ(cells.interval, block.intervals);
      size_t wrong = 0;
      for (size_t i = 0; i < count; ++i) {
        const CellCorners corners = cells.corners[i];
        const UnpackedSample cell = unpack_sample(packed[i]);
        wrong += cell.interval != (corners_suffice ? corner_interval(corners) : block.intervals[i]);
        for (size_t c = 0; corners_suffice && c < 8; ++c) wrong += cell.corners[c] != corners[c];
      }
      EXPECT_EQ(wrong, 0u) << largest << (corners_suffice ? ", corners suffice" : "");
    }
  }
}

/// A field chunk: of a block with the values of a field, for the cells of another one's chunk.
struct FieldChunk {
  Block field;
  std::vector<uint32_t> cells;
  uint32_t value_end = 0;
  std::vector<std::byte> bytes;
};
std::vector<FieldChunk> field_chunks() {
  std::vector<FieldChunk> chunks;
  ChunkEncoder encoder;
  ChunkDecoder decoder;
  for (const Index3 size : {Index3{11, 9, 6}, {1, 1, 1}, {64, 3, 2}}) {
    const Block block = make_block(size, Kind::smooth, 4095, true, 2);
    std::vector<std::byte> bytes;
    const uint32_t count = encoder.encode(block.view(), 0, 65535, bytes);
    DecodedCells cells;
    EXPECT_TRUE(decoder.decode(bytes, {size, 0, 65535, count, true}, cells));
    CellMask mask;
    EXPECT_TRUE(mask.set(cells.cell, size));
    for (const Kind kind : {Kind::noise, Kind::smooth, Kind::constant}) {
      for (const uint32_t largest : {255u, 65535u}) {
        FieldChunk chunk{
            make_block(size, kind, largest, false, largest), cells.cell, largest + 1, {}};
        encoder.encode_field(chunk.field.view(), mask, chunk.value_end, chunk.bytes);
        chunks.push_back(std::move(chunk));
      }
    }
  }
  return chunks;
}

Status decode_field(ChunkDecoder& decoder, const FieldChunk& chunk,
                    std::span<const std::byte> bytes, std::vector<CellCorners>& corners) {
  const auto decoded =
      decoder.decode_field(bytes, chunk.field.cells, chunk.cells, chunk.value_end, corners);
  EXPECT_EQ(corners.size(), decoded ? chunk.cells.size() : 0);
  return decoded ? Status::ok : decoded.error().status;
}

TEST(ChunkCodec, FieldChunksHoldTheValuesAtTheCornersOfTheCells) {
  ChunkDecoder decoder;
  std::vector<CellCorners> corners;
  for (const FieldChunk& chunk : field_chunks()) {
    ASSERT_EQ(decode_field(decoder, chunk, chunk.bytes, corners), Status::ok);
    for (size_t i = 0; i < corners.size(); ++i) {
      const auto cell = int32_t(chunk.cells[i]);
      ASSERT_EQ(corners[i], chunk.field.corners({cell & 63, cell >> 6 & 63, cell >> 12}));
    }
  }
}

TEST(ChunkCodec, FieldChunksAreDecodedInTheOrderOfTheSamples) {
  ChunkDecoder decoder;
  std::vector<PackedField> values;
  for (const FieldChunk& chunk : field_chunks()) {
    std::vector<PackedSample> samples;
    for (const uint32_t cell : chunk.cells) {
      const auto at = int32_t(cell);
      samples.push_back(pack_sample({at & 63, at >> 6 & 63, at >> 12}, {0, 9}, {}));
    }
    std::reverse(samples.begin(), samples.end());
    const auto decode = [&] {
      return decode_field_samples(decoder, chunk.bytes, chunk.field.cells, samples, chunk.value_end,
                                  values);
    };
    ASSERT_TRUE(decode());
    ASSERT_EQ(values.size(), samples.size());
    for (size_t i = 0; i < values.size(); ++i) {
      const CellCorners corners = chunk.field.corners(unpack_sample(samples[i]).cell);
      for (size_t c = 0; c < 8; ++c) {
        ASSERT_EQ(values[i].word[c / 2] >> 16 * (c % 2) & 0xffff, corners[c]);
      }
    }
    samples.push_back(samples.front());
    EXPECT_FALSE(decode());
    EXPECT_TRUE(values.empty());
  }
}

TEST(ChunkCodec, RefusesDamagedFieldChunks) {
  ChunkDecoder decoder;
  std::vector<CellCorners> corners;
  for (FieldChunk& chunk : field_chunks()) {
    for (size_t size = 0; size < chunk.bytes.size(); ++size) {
      EXPECT_NE(decode_field(decoder, chunk, std::span(chunk.bytes).first(size), corners),
                Status::ok);
    }
    for (size_t bit = 0; bit < chunk.bytes.size() * 8; ++bit) {
      chunk.bytes[bit / 8] ^= std::byte(1 << (bit & 7));
      decode_field(decoder, chunk, chunk.bytes, corners);
      chunk.bytes[bit / 8] ^= std::byte(1 << (bit & 7));
    }
    const std::vector<uint32_t> cells = chunk.cells;
    const auto with_cells = [&](std::vector<uint32_t> changed) {
      chunk.cells = std::move(changed);
      return decode_field(decoder, chunk, chunk.bytes, corners);
    };
    EXPECT_EQ(with_cells({}), Status::invalid_argument);
    EXPECT_EQ(with_cells({0, 0}), Status::invalid_argument);
    EXPECT_EQ(with_cells({64 * 64 * 64}), Status::invalid_argument);
    EXPECT_EQ(with_cells({uint32_t(chunk.field.cells.z) << 12}), Status::invalid_argument);
    if (cells.size() > 1) {
      EXPECT_NE(with_cells({cells.begin(), cells.end() - 1}), Status::ok);
    }
  }
}

/// FNV-1a.
uint64_t digest(std::span<const std::byte> bytes) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const std::byte b : bytes) hash = (hash ^ uint64_t(b)) * 0x100000001b3;
  return hash;
}

TEST(ChunkCodec, WritesTheSameBytesOnEveryMachine) {
  std::vector<std::byte> all;
  for (const SmallChunk& chunk : small_chunks()) {
    all.insert(all.end(), chunk.bytes.begin(), chunk.bytes.end());
  }
  ChunkEncoder encoder;
  const Block large = make_block({64, 40, 33}, Kind::smooth, 4095, true, 1);
  encoder.encode(large.view(), 1000, 3000, all);
  EXPECT_EQ(all.size(), 39957u);
  EXPECT_EQ(digest(all), 7852987908364789221u);
}

TEST(ChunkCodec, VectorOperationsEqualScalarOnes) {
  Random random{11};
  for (int i = 0; i < 20000; ++i) {
    int16_t rows[4][4], weights[2][16];
    for (auto& row : rows) {
      for (int16_t& v : row) v = int16_t(random());
    }
    for (auto& of_point : weights) {
      for (int k = 0; k < 16; ++k) {
        of_point[k] = int16_t(k > 3 && k % 4 == 3 ? 0 : int(random() % 2047) - 1023);
      }
    }
    const auto point = [&](int k) {
      return WeightedTaps{{rows[k], rows[(k + 1) & 3], rows[(k + 2) & 3], rows[(k + 3) & 3]},
                          rows[k ^ 1],
                          weights[k & 1]};
    };
    int32_t scalar_sums[4], vector_sums[4];
    ScalarOps::sum_four(point, scalar_sums);
    VectorOps::sum_four(point, vector_sums);
    ASSERT_TRUE(std::equal(scalar_sums, scalar_sums + 4, vector_sums));

    uint64_t words[5];
    for (uint64_t& word : words) {
      word = uint64_t{random()} << 41 | uint64_t{random()} << 20 | random();
    }
    int16_t energies[3][kBlockCells + 2 + 8];
    for (auto& row : energies) {
      for (int16_t& energy : row) energy = int16_t((random() & kMaxEnergy) >> random() % 13);
    }
    const EnergyRows around{energies[0], energies[1], energies[2]};
    // Of each point its x, class and octave.
    std::array<std::array<uint8_t, 64 + PlanePoints::kSlack>, 3> scalar, vector;
    const int32_t points = ScalarOps::list_points(words[4], words, around, scalar[0].data(),
                                                  scalar[1].data(), scalar[2].data());
    ASSERT_EQ(VectorOps::list_points(words[4], words, around, vector[0].data(), vector[1].data(),
                                     vector[2].data()),
              points);
    for (size_t k = 0; k < 3; ++k) {
      ASSERT_TRUE(std::equal(scalar[k].begin(), scalar[k].begin() + points, vector[k].begin()));
    }

    QuantizedValue quantized_values[64];
    for (QuantizedValue& quantized : quantized_values) quantized = QuantizedValue(random());
    const auto columns = int32_t(1 + random() % 64);
    const uint64_t here = words[0] & valid_cells(columns);
    std::array<int16_t, 64> scalar_row{}, vector_row{};
    ASSERT_EQ(VectorOps::set_points(here, quantized_values, columns, vector_row.data()),
              ScalarOps::set_points(here, quantized_values, columns, scalar_row.data()));
    ASSERT_EQ(vector_row, scalar_row);

    CellInterval intervals[23];
    for (CellInterval& interval : intervals)
      interval = {QuantizedValue(random()), QuantizedValue(random())};
    if (i % 5 == 0) intervals[i % 23] = {65535, 65535};
    const uint32_t begin = random() % 65536, end = i % 3 ? begin + random() % 100 : 65536;
    ASSERT_EQ(VectorOps::active_cells(intervals, 23, begin, end),
              ScalarOps::active_cells(intervals, 23, begin, end));
  }
  const QuadSlots slots;
  for (int context = 0; context < 256; ++context) {
    for (uint32_t slot = 0; slot < kQuadTotal; ++slot) {
      ASSERT_EQ(VectorOps::find_quad(slots.start[context], slot),
                ScalarOps::find_quad(slots.start[context], slot));
    }
  }
}

TEST(ChunkCodec, OctavesOfARowAreThoseOfItsSums) {
  Random random{5};
  Energies energies;
  for (int i = 0; i < 200; ++i) {
    energies.reset();
    for (int32_t y = 0; y <= 64; ++y) {
      for (int32_t x = 0; x <= 64; ++x) {
        energies.set(x, y, i > 0 ? int32_t(random() % 8192 >> random() % 13) - 4096 : 65535);
      }
    }
    const auto y = int32_t(random() % 65);
    const uint64_t no_classes[4] = {};
    uint8_t places[64 + PlanePoints::kSlack], classes[64 + PlanePoints::kSlack];
    uint8_t octaves[64 + PlanePoints::kSlack];
    VectorOps::list_points(~uint64_t{0}, no_classes, energies.around(y), places, classes, octaves);
    octaves[64] = uint8_t(half_octave(energies.around(y).around(64)));
    for (int32_t x = 0; x <= 64; ++x) {
      uint32_t sum = 0;
      for (int32_t j = -1; j <= 1; ++j) {
        for (int32_t k = -1; k <= 1; ++k) {
          const int32_t weight = (2 - std::abs(j)) * (2 - std::abs(k));
          sum += uint32_t(weight * energies.values[y + j + 1][x + k + 1]);
        }
      }
      ASSERT_EQ(octaves[x], half_octave(sum));
    }
  }
}

TEST(PackCells, VectorsEqualScalars) {
  Random random{13};
  for (int i = 0; i < 20000; ++i) {
    Row values[4];
    const uint32_t spread = 16 - random() % 14;
    const int32_t base = int32_t(random() % 65536) - 32768;
    for (auto& row : values) {
      for (int16_t& v : row.value) v = int16_t(base + int32_t(random() % (1u << spread)));
    }
    IntervalRow intervals;
    for (int x = 0; x < kBlockCells; ++x) {
      intervals.min[x] = QuantizedValue(random() % 65535);
      intervals.max[x] =
          QuantizedValue(intervals.min[x] + 1 + random() % (65535u - intervals.min[x]));
    }
    const CellRows rows(values[0], values[1], values[2], values[3]);
    const uint64_t some = uint64_t{random()} << 41 | uint64_t{random()} << 20 | random();
    const uint64_t cells = i % 3 == 0 ? ~uint64_t{0} : i % 3 == 1 ? some : some & some << 7;
    const uint32_t place = (random() % 4096) << 6;
    const IntervalRow* given = i % 2 ? &intervals : nullptr;
    std::vector<PackedSample> expected(64), found(64 + kPackedSlack);
    expected.resize(
        size_t(pack_cells_scalar(cells, place, rows, given, expected.data()) - expected.data()));
    const auto* end = pack_cells(cells, place, rows, given, found.data());
    ASSERT_EQ(end - found.data(), __builtin_popcountll(cells));
    found.resize(expected.size());
    ASSERT_EQ(found, expected);
  }
}

TEST(ChunkTables, DistributionsFillTheirTotals) {
  uint16_t frequencies[32];
  for (const char* letters : kQuadTable) {
    read_distribution(letters, 16, kQuadTotal, frequencies);
    uint32_t sum = 0;
    for (int i = 0; i < 16; ++i) {
      sum += frequencies[i];
      EXPECT_GE(frequencies[i], 1);
    }
    EXPECT_EQ(sum, kQuadTotal);
  }
  for (const auto& letters : kTokenTable) {
    read_distribution(letters, kTokens, kTokenTotal, frequencies);
    uint32_t sum = 0;
    for (int i = 0; i < kTokens; ++i) {
      sum += frequencies[i];
      EXPECT_GE(frequencies[i], 1);
    }
    EXPECT_EQ(sum, kTokenTotal);
  }
  for (const auto& taps : kDefaultWeights) {
    int sum = 0;
    for (const int16_t weight : taps) sum += weight;
    EXPECT_EQ(sum, 128);
  }
}

}  // namespace
}  // namespace isosplat
