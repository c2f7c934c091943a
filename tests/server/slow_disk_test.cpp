// Reads that wait for a disk: they delay no other connection.
//
// The linker replaces pread calls of this program by the functions below (--wrap), which make files
// named "slow…" behave as those of a slow disk: without waiting, their bytes are never there;
// otherwise a read waits until the test opens the gate.

#include <gtest/gtest.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <mutex>
#include <string>

#include "tests/server/server_fixture.h"

namespace {

class Gate {
 public:
  void close() {
    const std::lock_guard lock(mutex_);
    is_open_ = false;
  }
  void open() {
    const std::lock_guard lock(mutex_);
    is_open_ = true;
    changed_.notify_all();
  }
  void pass() {
    std::unique_lock lock(mutex_);
    ++waiting_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return is_open_; });
    --waiting_;
  }
  /// Waits until as many reads wait.
  void await(int reads) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_ >= reads; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_open_ = true;  // guarded by mutex_
  int waiting_ = 0;      // guarded by mutex_
};

Gate& gate() {
  static Gate gate;
  return gate;
}

bool is_slow(int descriptor) {
  char target[4096];
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const ssize_t length = ::readlink(link.c_str(), target, sizeof target);
  return length > 0 && std::string_view(target, static_cast<size_t>(length)).find("/slow") !=
                           std::string_view::npos;
}

}  // namespace

extern "C" {
ssize_t __real_preadv2(int descriptor, const iovec* to, int count, off_t offset, int flags);
ssize_t __wrap_preadv2(int descriptor, const iovec* to, int count, off_t offset, int flags);

ssize_t __wrap_preadv2(int descriptor, const iovec* to, int count, off_t offset, int flags) {
  if (is_slow(descriptor)) {
    if (flags & RWF_NOWAIT) {
      errno = EAGAIN;
      return -1;
    }
    gate().pass();
  }
  return __real_preadv2(descriptor, to, count, offset, flags);
}
}

namespace isosplat::test {
namespace {

class SlowDisk : public ServerTest {
 protected:
  SlowDisk() {
    options.threads = 1;  // the other connections are of the same thread
    options.disk_threads = 2;
    write_file(folder.path() / "slow.isosplat", slow.file);
  }
  ~SlowDisk() override { gate().open(); }

  std::string slow_content(const std::string& rest) const {
    return "/v1/volumes/slow/" + slow.content + "/" + rest;
  }
  static std::string request_for(const std::string& target) {
    return "GET " + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  }
  const KnownChunk& chunk_of(const KnownStore& store) const {
    for (const KnownChunk& chunk : store.chunks) {
      if (chunk.cells > 0) return chunk;
    }
    throw std::runtime_error("no chunk");
  }

  const KnownStore slow = make_store(7);
};

TEST_F(SlowDisk, DelaysOnlyWhoReadsFromIt) {
  start();
  gate().close();
  Client waiting(port());
  waiting.send(request_for(slow_content("chunks/" + place_of(chunk_of(slow)))));
  gate().await(1);
  Client other(port());
  for (int i = 0; i < 3; ++i) {
    const Answer answer = other.request("GET", content("chunks/" + place_of(chunk_of(alpha))));
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body, text_of(chunk_of(alpha).bytes));
  }
  gate().open();
  const Answer answer = waiting.receive();
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, text_of(chunk_of(slow).bytes));
}

TEST_F(SlowDisk, ManyReadersWaitInTheQueue) {
  start();
  gate().close();
  std::vector<Client> waiting;
  for (int i = 0; i < 20; ++i) {
    waiting.emplace_back(port());
    waiting.back().send(request_for(slow_content("chunks/" + place_of(chunk_of(slow)))));
  }
  gate().await(2);
  EXPECT_EQ(get(port(), content("file")).body, text_of(alpha.file));
  gate().open();
  for (Client& client : waiting) {
    EXPECT_EQ(client.receive().body, text_of(chunk_of(slow).bytes));
  }
}

TEST_F(SlowDisk, HasTheSameAnswersByEveryRoute) {
  start();
  EXPECT_EQ(get(port(), slow_content("file")).body, text_of(slow.file));
  EXPECT_EQ(get(port(), slow_content("file"), "Range: bytes=100-99999\r\n").body,
            text_of(slow.file).substr(100, 99900));
  EXPECT_EQ(get(port(), slow_content("pages/0")).status, 200);
  EXPECT_EQ(get(port(), "/v1/volumes/slow/bootstrap").status, 200);
  const Answer frames = get(port(), slow_content("chunks?isovalue=-1e9..1e9&level=0"));
  EXPECT_EQ(frames.status, 200);
  EXPECT_TRUE(frames.complete);
  EXPECT_EQ(get(port(), slow_content("chunks/0/0.0.0/99")).status, 404);
}

TEST_F(SlowDisk, AStopWaitsForItsReads) {
  options.limits.stop_time = std::chrono::seconds(60);
  start();
  gate().close();
  Client waiting(port());
  waiting.send(request_for(slow_content("chunks/" + place_of(chunk_of(slow)))));
  gate().await(1);
  server->stop();
  gate().open();
  EXPECT_EQ(waiting.receive().body, text_of(chunk_of(slow).bytes));
  server->wait();
}

TEST_F(SlowDisk, AClientThatLeavesIsNotMissed) {
  start();
  gate().close();
  {
    Client leaving(port());
    leaving.send(request_for(slow_content("file")));
    gate().await(1);
  }
  EXPECT_EQ(get(port(), "/healthz").status, 200);
  gate().open();
  EXPECT_EQ(get(port(), slow_content("pages/0")).status, 200);
}

}  // namespace
}  // namespace isosplat::test
