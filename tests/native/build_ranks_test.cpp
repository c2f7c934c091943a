// Builds by several ranks give byte for byte the store of one build. The ranks of these tests are
// threads; mpi_test.cpp tests processes.
#include <deque>
#include <mutex>
#include <thread>

#include "native/cluster/messages.h"
#include "native/cluster/rank_build.h"
#include "tests/native/wave_volume.h"

namespace isosplat {
namespace {

using test::Volume;

/// The messages between ranks that are threads.
struct Post {
  explicit Post(int ranks) : boxes(static_cast<size_t>(ranks)) {}
  std::mutex mutex;
  std::vector<std::deque<Message>> boxes;
};

class ThreadTransport : public Transport {
 public:
  ThreadTransport(Post& post, int rank) : post_(post), rank_(rank) {}
  int rank() const override { return rank_; }
  int ranks() const override { return static_cast<int>(post_.boxes.size()); }
  void send(int to, MessageKind kind, std::vector<std::byte> content) override {
    const std::lock_guard lock(post_.mutex);
    post_.boxes[static_cast<size_t>(to)].push_back({rank_, kind, std::move(content)});
  }
  std::optional<Message> receive() override {
    const std::lock_guard lock(post_.mutex);
    auto& box = post_.boxes[static_cast<size_t>(rank_)];
    if (box.empty()) return std::nullopt;
    Message message = std::move(box.front());
    box.pop_front();
    return message;
  }
  bool is_busy() const override { return false; }

 private:
  Post& post_;
  const int rank_;
};

/// A volume whose slices from `bad` on cannot be read.
template <class Source>
class BrokenSource : public VolumeSource {
 public:
  BrokenSource(Source& source, int32_t bad) : source_(source), bad_(bad) {}
  const VolumeHeader& header() const override { return source_.header(); }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    if (first + count > bad_) return fail(Status::io_error, "the disk is broken");
    return source_.read_slices(first, count, out);
  }
  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  Source& source_;
  const int32_t bad_;
};

struct Built {
  std::string store, error;
};

/// Builds with ranks. `serve(rank, transport)`: what the ranks other than 0 do.
template <class T, class Serve>
Built build_with(const Volume<T>& volume, int ranks, const BuildOptions& options, Serve serve) {
  Post post(ranks);
  std::vector<std::jthread> others;
  for (int rank = 1; rank < ranks; ++rank) {
    others.emplace_back([&, rank] {
      ThreadTransport transport(post, rank);
      serve(rank, transport);
    });
  }
  ThreadTransport transport(post, 0);
  ArraySource<T> source = volume.source();
  MemorySink sink;
  const auto built = build_store_on_ranks(source, sink, options, transport);
  stop_ranks(transport, 0);
  if (!built) return {"", built.error().message};
  return {Volume<T>::text(sink.bytes), ""};
}

/// Ranks with odd numbers have `more` threads.
template <class T>
Built build_on(const Volume<T>& volume, int ranks, const BuildOptions& options = {},
               unsigned more = 1) {
  return build_with(volume, ranks, options, [&](int rank, Transport& transport) {
    ArraySource<T> source = volume.source();
    BuildOptions of_rank = options;
    of_rank.clamped = nullptr;
    of_rank.threads = options.threads + (rank % 2 ? more : 0);
    serve_rank(source, of_rank, transport);
  });
}

template <class T>
void expect_same_stores(const Volume<T>& volume, BuildOptions options = {}) {
  const std::string whole = volume.store(options);
  options.threads = 1;
  for (const int ranks : {1, 2, 3, 4, 7}) {
    const Built built = build_on(volume, ranks, options);
    EXPECT_EQ(built.error, "");
    EXPECT_TRUE(built.store == whole) << ranks << " ranks";
  }
}

TEST(BuildRanks, GiveTheStoreOfOneBuild) {
  expect_same_stores(Volume<uint8_t>({141, 150, 131}));
  expect_same_stores(Volume<uint16_t>({131, 66, 200}, 1.0));  // noise: size limits change blocks
  expect_same_stores(Volume<float>({90, 131, 141}, 0.02));
  expect_same_stores(Volume<double>({70, 75, 133}, 0.5));
  expect_same_stores(Volume<int16_t>({23, 17, 9}, 0.1));  // one block
  expect_same_stores(Volume<uint32_t>({64, 65, 66}, 0.1));
}

TEST(BuildRanks, GiveTheStoreOfOneBuildWithOptions) {
  const Volume<float> volume({90, 131, 141}, 0.1);
  BuildOptions options;
  options.max_error = 0.5;
  options.fetch_weight = 0.3;
  expect_same_stores(volume, options);
  options.title = "waves";
  options.range = ValueRange{40, 150};
  expect_same_stores(volume, options);
}

TEST(BuildRanks, GiveTheStoreOfOneBuildInBandsOfRows) {
  const auto check = [](const auto& volume) {
    auto source = volume.source();
    BuildOptions options;
    options.threads = 1 + kMessageEncoders;
    options.memory_bytes = min_memory(source, options);  // of a rank with one thread
    options.threads = 1;
    for (const int ranks : {1, 2, 3, 7}) {
      const Built built = build_on(volume, ranks, options, 0);
      EXPECT_EQ(built.error, "");
      EXPECT_TRUE(built.store == volume.store()) << ranks << " ranks";
    }
  };
  check(Volume<uint8_t>({70, 300, 131}));
  check(Volume<uint16_t>({66, 200, 131}, 1.0));
}

TEST(BuildRanks, CountWhatTheRangeChanges) {
  const Volume<float> volume({90, 131, 141}, 0.1);
  ClampedVoxels once, on_ranks;
  BuildOptions options;
  options.range = ValueRange{40, 150};
  options.clamped = &once;
  volume.store(options);
  options.clamped = &on_ranks;
  EXPECT_EQ(build_on(volume, 3, options).error, "");
  EXPECT_GT(once.below, 0u);
  EXPECT_EQ(on_ranks.below, once.below);
  EXPECT_EQ(on_ranks.above, once.above);
}

TEST(BuildRanks, UseATemporaryFileForCoarseLevels) {
  const Volume<uint16_t> volume({150, 150, 140}, 0.05);
  ArraySource<uint16_t> source = volume.source();
  BuildOptions options;
  options.threads = 1;
  const std::string whole = volume.store(options);
  options.threads = 3;  // those of messages included
  options.memory_bytes = min_memory(source, options);
  options.threads = 1;
  const Built built = build_on(volume, 2, options, 0);
  EXPECT_EQ(built.error, "");
  EXPECT_TRUE(built.store == whole);
}

TEST(BuildRanks, AnErrorOfOneRankEndsAll) {
  const Volume<uint16_t> volume({131, 66, 200});
  for (const int bad : {0, 66, 100}) {
    const Built built = build_with(volume, 3, {}, [&](int rank, Transport& transport) {
      ArraySource<uint16_t> source = volume.source();
      BrokenSource broken(source, rank == 2 ? bad : 200);
      serve_rank(broken, {}, transport);
    });
    EXPECT_EQ(built.error, "rank 2: the disk is broken");
  }
}

TEST(BuildRanks, ARankThatCannotOpenTheVolumeEndsAll) {
  const Volume<uint16_t> volume({31, 66, 20});
  const Built built = build_with(volume, 2, {}, [](int, Transport& transport) {
    refuse_rank({Status::io_error, "no such file"}, transport);
  });
  EXPECT_EQ(built.error, "rank 1: no such file");
}

TEST(BuildRanks, AnotherVolumeIsAnError) {
  const Volume<uint16_t> volume({31, 66, 20}), other({31, 66, 21});
  const Built built = build_with(volume, 2, {}, [&](int, Transport& transport) {
    ArraySource<uint16_t> source = other.source();
    serve_rank(source, {}, transport);
  });
  EXPECT_NE(built.error.find("rank 1: expected the volume that rank 0 has opened"),
            std::string::npos)
      << built.error;
}

TEST(BuildRanks, TooLittleMemoryIsAnErrorOfRank0) {
  BuildOptions options;
  options.memory_bytes = 1 << 20;
  const Built built = build_on(Volume<uint16_t>({131, 66, 200}), 3, options);
  EXPECT_NE(built.error.find("memory"), std::string::npos) << built.error;
}

}  // namespace
}  // namespace isosplat
