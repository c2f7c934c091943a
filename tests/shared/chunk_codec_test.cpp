#include "shared/codec/chunk_codec.h"

#include <gtest/gtest.h>

namespace isosplat {
namespace {

/// The same numbers with every standard library.
struct Random {
  uint32_t state;
  uint32_t operator()() {
    state = state * 1664525 + 1013904223;
    return state >> 8;
  }
};

struct Block {
  Index3 cells;
  std::vector<Code> voxels;
  std::vector<CellInterval> intervals;
  bool has_intervals = false;

  BlockView view() const { return {cells, voxels.data(), intervals.data(), has_intervals}; }

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
        block.voxels.push_back(Code(std::min(value, largest)));
      }
    }
  }
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      for (int32_t x = 0; x < cells.x; ++x) {
        CellInterval interval = corner_interval(block.corners({x, y, z}));
        if (widened) {
          interval.min = Code(interval.min - std::min<uint32_t>(interval.min, random() % 9));
          interval.max = Code(std::min<uint32_t>(largest, interval.max + random() % 9));
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
          const Block block = make_block(cells, kind, largest, widened, ++seed);
          for (const auto& [begin, end] :
               {std::pair{0u, 65536u}, std::pair{0u, 1u}, std::pair{largest / 3, largest / 3 + 1},
                std::pair{largest / 4, largest / 2 + 1}, std::pair{largest / 2, 65536u}}) {
            SCOPED_TRACE(testing::Message()
                         << cells.x << "x" << cells.y << "x" << cells.z << " kind " << int(kind)
                         << " largest " << largest << " widened " << widened << " slab " << begin
                         << ".." << end << " seed " << seed);
            expect_round_trip(block, begin, end, encoder, decoder);
            if (HasFatalFailure()) return;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace isosplat
