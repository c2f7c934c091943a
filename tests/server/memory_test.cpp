// If the process gets no more memory, requests get 503, and the server continues.

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "native/builder/array_source.h"
#include "server/limits/memory_limit.h"
#include "shared/system/store_file/store_file.h"
#include "tests/server/server_fixture.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ISOSPLAT_HAS_OWN_ALLOCATOR
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define ISOSPLAT_HAS_OWN_ALLOCATOR
#endif
#endif

namespace isosplat::server::test {
namespace {

constexpr uint64_t kMiB = 1 << 20;

/// Limits the address space of this process, like ulimit -v, to its current size plus `more` bytes.
class MemoryLimit {
 public:
  explicit MemoryLimit(uint64_t more) {
    ::getrlimit(RLIMIT_AS, &before_);
    std::ifstream statm("/proc/self/statm");
    uint64_t pages = 0;
    statm >> pages;
    const rlimit limit{pages * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE)) + more,
                       before_.rlim_max};
    ::setrlimit(RLIMIT_AS, &limit);
  }
  ~MemoryLimit() { ::setrlimit(RLIMIT_AS, &before_); }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
};

class LittleMemory : public ServerTest {
 protected:
  void SetUp() override {
#ifdef ISOSPLAT_HAS_OWN_ALLOCATOR
    GTEST_SKIP() << "a sanitizer's allocator ends the program";
#endif
    VolumeGrid grid;
    grid.voxels = {70, 40, 40};
    std::vector<uint8_t> voxels;
    for (int32_t i = 0; i < 70 * 40 * 40; ++i) voxels.push_back(static_cast<uint8_t>(i % 70));
    const auto path = folder.path() / "points.isosplat";
    ASSERT_TRUE(build_store_file<uint8_t>(grid, voxels, path));
    samples =
        "/v1/volumes/points/" + (*StoreFile::open(path))->content() + "/samples?isovalue=60.5";
    start();
    for (const std::string& target : targets()) ASSERT_EQ(get(port(), target).status, 200);
  }

  std::vector<std::string> targets() const {
    return {samples,       content("file"),
            "/v1/volumes", "/v1/openapi.json",
            "/healthz",    content("chunks?isovalue=-1e9..1e9&level=0")};
  }

  std::string samples;
};

TEST_F(LittleMemory, IsComparedWithARequestedSize) {
  EXPECT_TRUE(has_memory_for(1000 * kMiB));
  const MemoryLimit limit(64 * kMiB);
  EXPECT_TRUE(has_memory_for(1 * kMiB));
  EXPECT_FALSE(has_memory_for(65 * kMiB));
}

TEST_F(LittleMemory, RequestsAreRefusedAndLaterServed) {
  Client client(port());
  ASSERT_EQ(client.request("GET", "/healthz").status, 200);
  {
    const MemoryLimit limit(4 * kMiB);
    for (const std::string& target : targets()) {
      const Answer answer = client.request("GET", target);
      // Small allocations may succeed, since they can use freed memory.
      EXPECT_TRUE(answer.status == 503 || (answer.status == 200 && target != samples)) << target;
      if (answer.status == 200) continue;
      EXPECT_EQ(answer.header("retry-after"), "1");
      EXPECT_NE(answer.body.find("memory"), std::string::npos) << answer.body;
    }
  }
  for (const std::string& target : targets()) {
    EXPECT_EQ(client.request("GET", target).status, 200) << target;
  }
  const std::string metrics = client.request("GET", "/metrics").body;
  const std::string name = "\nisosplat_out_of_memory_total ";
  const size_t at = metrics.find(name);
  ASSERT_NE(at, std::string::npos);
  EXPECT_GE(std::stoul(metrics.substr(at + name.size())), 1u);
}

TEST_F(LittleMemory, UnderLoadEndsNothing) {
  std::atomic<int> served{0}, refused{0};
  {
    const MemoryLimit limit(60 * kMiB);
    std::vector<std::thread> loops;
    for (int i = 0; i < 4; ++i) {
      loops.emplace_back([&] {
        for (int round = 0; round < 10; ++round) {
          for (const std::string& target : targets()) {
            const int status = get(port(), target).status;
            ++(status == 200 ? served : refused);
            EXPECT_TRUE(status == 200 || status == 503 || status == 0) << status;
          }
        }
      });
    }
    for (std::thread& loop : loops) loop.join();
  }
  EXPECT_EQ(served + refused, 4 * 10 * 6);
  for (const std::string& target : targets()) EXPECT_EQ(get(port(), target).status, 200) << target;
}

}  // namespace
}  // namespace isosplat::server::test
