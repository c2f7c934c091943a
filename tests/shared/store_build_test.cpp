// Compares a build whose blocks are encoded in place with a build whose blocks travel as messages:
// both yield the same store, natively and as WebAssembly.

#include <gtest/gtest.h>

#include <array>
#include <deque>

#include "shared/core/builder/block_transfer.h"
#include "shared/core/builder/store_build.h"

namespace isosplat {
namespace {

/// A ball in noise, with several levels and bands, and with blocks that are not full.
class Ball : public VolumeSource {
 public:
  explicit Ball(Index3 voxels) {
    header_.grid.voxels = voxels;
    header_.type = VoxelType::u16;
    header_.name = "ball";
    header_.format = "raw";
  }
  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const Index3 n = header_.grid.voxels;
    auto* to = reinterpret_cast<uint16_t*>(out.data());
    for (int32_t z = first; z < first + count; ++z) {
      for (int32_t y = 0; y < n.y; ++y) {
        for (int32_t x = 0; x < n.x; ++x) {
          const int32_t dx = x - n.x / 2, dy = y - n.y / 2, dz = z - n.z / 2;
          const uint32_t noise =
              (static_cast<uint32_t>(x * 31 + y * 17 + z * 7) * 2654435761u) >> 28;
          *to++ = static_cast<uint16_t>(std::max(0, 3000 - (dx * dx + dy * dy + dz * dz)) + noise);
        }
      }
    }
    return {};
  }
  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  VolumeHeader header_;
};

constexpr Index3 kVoxels{135, 70, 129};

struct Built {
  std::vector<std::byte> store;
  BuildReport report;
};

/// Builds with `encoders` encoders. If blocks travel as messages, they are added in an order that
/// differs from the order in which they began.
Built build_store(bool as_messages, size_t encoders,
                  std::optional<double> only_isovalue = std::nullopt) {
  Ball source(kVoxels);
  MemorySink sink;
  SerialExecutor executor;
  StoreOptions options;
  options.only_isovalue = only_isovalue;
  StoreBuild build(source, sink, options, executor, static_cast<unsigned>(encoders), nullptr);
  std::vector<BlockEncoder> all(encoders);
  EXPECT_TRUE(build.begin());
  while (*build.next_layer()) {
    size_t turn = 0;
    while (!build.layer_is_complete()) {
      std::deque<BlockTask> begun;
      while (auto task = build.begin_block()) begun.push_back(*task);
      while (!begun.empty()) {
        const BlockTask task = begun.back();
        begun.pop_back();
        BlockEncoder& encoder = all[turn++ % encoders];
        EncodedBlock encoded;
        if (as_messages) {
          std::vector<std::byte> message, answer;
          write_task(build.layer(), build.coarser(), task, kVoxels, message);
          EXPECT_TRUE(encode_task(message, build.isovalue_distribution(), encoder, answer));
          EXPECT_EQ(read_encoded(answer, build.layer(), build.coarser(), encoded).value(),
                    task.number);
        } else {
          BandsEncoder bands;
          encoder.encode(build.layer(), build.coarser(), task, bands, encoded);
        }
        EXPECT_TRUE(build.add_block(task.number, std::move(encoded)));
      }
    }
  }
  VolumeStatistics statistics;
  for (const BlockEncoder& encoder : all) EXPECT_TRUE(statistics.add(encoder.statistics.bytes()));
  auto report = build.finish(statistics);
  EXPECT_TRUE(report);
  return {std::move(sink.bytes), *report};
}

/// A build that has begun.
struct BegunBuild {
  Ball source{kVoxels};
  MemorySink sink;
  SerialExecutor executor;
  const StoreOptions options;
  StoreBuild build{source, sink, options, executor, 1, nullptr};

  BegunBuild() { EXPECT_TRUE(build.begin()); }
};

TEST(StoreBuild, BlocksAsMessagesGiveTheSameStore) {
  const Built in_place = build_store(false, 1);
  EXPECT_GT(in_place.report.info.chunk_count, 30u);
  EXPECT_EQ(build_store(true, 3).store, in_place.store);
}

TEST(StoreBuild, MessagesStateThatAStoreIsForOneIsovalue) {
  const Built all = build_store(false, 1);
  const double isovalue = all.report.info.mapping.value(
      (all.report.info.range.min + all.report.info.range.max) / 2 + 0.5);
  const Built one = build_store(false, 1, isovalue);
  EXPECT_LT(one.store.size(), all.store.size() / 2);
  EXPECT_EQ(build_store(true, 3, isovalue).store, one.store);
  EXPECT_EQ(one.report.info.metadata.find("histogram"), std::string::npos);
  EXPECT_NE(one.report.info.metadata.find("\"active_cells\":{\"low\":"), std::string::npos);
}

TEST(StoreBuild, BlocksEncodedInPlaceGiveTheSameMessages) {
  BegunBuild begun;
  StoreBuild& build = begun.build;
  BlockEncoder encoder;
  while (*build.next_layer()) {
    while (const auto task = build.begin_block()) {
      std::vector<std::byte> message, answer, in_place;
      write_task(build.layer(), build.coarser(), *task, kVoxels, message);
      ASSERT_TRUE(encode_task(message, build.isovalue_distribution(), encoder, answer));
      BandsEncoder bands;
      EncodedBlock encoded;
      encoder.encode(build.layer(), build.coarser(), *task, bands, encoded);
      write_encoded(build.layer(), build.coarser(), task->number, encoded, in_place);
      EXPECT_TRUE(in_place == answer) << task->number;
      ASSERT_TRUE(is_result_of(encoded, *task));
      ASSERT_TRUE(build.add_block(task->number, std::move(encoded)));
    }
  }
}

TEST(StoreBuild, MessagesOfAnyOtherSizeAreRefused) {
  BegunBuild begun;
  StoreBuild& build = begun.build;
  ASSERT_TRUE(*build.next_layer());
  std::vector<std::byte> task, answer, unused;
  write_task(build.layer(), build.coarser(), *build.begin_block(), kVoxels, task);
  BlockEncoder encoder;
  ASSERT_TRUE(encode_task(task, build.isovalue_distribution(), encoder, answer));
  const auto refuses_task = [&](std::span<const std::byte> bytes) {
    const auto encoded = encode_task(bytes, build.isovalue_distribution(), encoder, unused);
    return !encoded && encoded.error().status == Status::invalid_argument;
  };
  const auto refuses_answer = [&](std::span<const std::byte> bytes) {
    EncodedBlock block;
    const auto read = read_encoded(bytes, build.layer(), build.coarser(), block);
    return !read && read.error().status == Status::invalid_argument;
  };
  for (size_t bytes = 0; bytes < task.size(); bytes += 1 + bytes / 3) {
    EXPECT_TRUE(refuses_task(std::span(task).first(bytes))) << bytes;
  }
  for (size_t bytes = 0; bytes < answer.size(); bytes += 1 + bytes / 3) {
    EXPECT_TRUE(refuses_answer(std::span(answer).first(bytes))) << bytes;
  }
  task.push_back({});
  answer.push_back({});
  EXPECT_TRUE(refuses_task(task));
  EXPECT_TRUE(refuses_answer(answer));
}

TEST(StoreBuild, WithoutTemporaryFilesAVolumeThatDoesNotFitIsRefusedBeforeItIsRead) {
  Ball source({3000, 3000, 3000});
  MemorySink sink;
  SerialExecutor executor;
  const StoreOptions options;
  StoreBuild build(source, sink, options, executor, 2, nullptr);
  const auto begun = build.begin();
  ASSERT_FALSE(begun);
  EXPECT_EQ(begun.error().status, Status::out_of_memory);
  EXPECT_NE(begun.error().message.find("isosplat build"), std::string::npos);
}

TEST(StoreBuild, StatisticsOfAnotherSizeAreRefused) {
  VolumeStatistics statistics;
  std::vector<std::byte> bytes = statistics.bytes();
  bytes.pop_back();
  EXPECT_FALSE(statistics.add(bytes));
}

}  // namespace
}  // namespace isosplat
