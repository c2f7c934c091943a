// SIGHUP and SIGTERM while clients are busy: all bytes are correct, and no request is lost.

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <csignal>
#include <deque>
#include <thread>

#include "tests/server/faulty_disk.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

constexpr const char* kToken = "token-0123456789abcdef";
constexpr const char* kOther = "other-0123456789abcdef";

class Signals : public ServerTest {
 protected:
  static constexpr size_t kClients = 4;

  Signals() {
    write_file(folder.path() / "large.isosplat", large.file);
    write_file(folder.path() / "slow.isosplat", alpha.file);
    options.handle_signals = true;
    options.token_file = secrets.path() / "tokens";
    write_file(options.token_file, std::string(kToken) + " *\n" + kOther + " *\n");
    options.log = [this](std::string_view line) { reloads += line.find("opened again") != npos; };
    options.limits.stop_time = std::chrono::minutes(10);
  }
  ~Signals() override {
    gate().open();
    is_over = true;
    for (std::thread& thread : threads) thread.join();
  }

  static std::string bearer(const char* token) {
    return std::string("Authorization: Bearer ") + token + "\r\n";
  }

  /// Starts clients, each with one connection, that request files and headers until is_over. If
  /// may_close, a client also stops when the server closes its connection between two responses.
  void start_clients(bool may_close) {
    for (size_t i = 0; i < kClients; ++i) {
      threads.emplace_back([this, i, may_close] {
        Client client(port());
        for (size_t turn = i; !is_over; ++turn) {
          const bool is_file = turn % 2 == 0;
          const Answer answer =
              client.request("GET", content(is_file ? "file" : "header"), bearer(kToken));
          if (answer.status == 0 && may_close) {
            EXPECT_EQ(client.read(1), "") << "a response ends in its header";
            return;
          }
          ASSERT_EQ(answer.status, 200) << answer.body;
          EXPECT_TRUE(answer.complete);
          const std::string file = text_of(alpha.file);
          EXPECT_TRUE(is_file ? answer.body == file : file.starts_with(answer.body));
          ++responses[i];
        }
      });
    }
  }

  /// Waits until each client has had another response.
  bool await_responses() {
    std::array<int, kClients> before{};
    for (size_t i = 0; i < kClients; ++i) before[i] = responses[i];
    return eventually([&] {
      for (size_t i = 0; i < kClients; ++i) {
        if (responses[i] <= before[i]) return false;
      }
      return true;
    });
  }

  static constexpr size_t npos = std::string_view::npos;
  const KnownStore large = make_store(3, {128, 128, 128}, 2'000'000);  // more than sockets take
  TemporaryFolder secrets;
  std::atomic<int> reloads{0};
  std::atomic<bool> is_over{false};
  std::array<std::atomic<int>, kClients> responses{};
  std::deque<std::thread> threads;
};

TEST_F(Signals, AReloadLosesNoRequest) {
  start();
  start_clients(false);
  ASSERT_TRUE(await_responses());
  for (int i = 1; i <= 20; ++i) {
    const bool has_other = i % 2 == 0;
    write_file(options.token_file,
               std::string(kToken) + " *\n" + (has_other ? std::string(kOther) + " *\n" : ""));
    std::raise(SIGHUP);
    ASSERT_TRUE(eventually([&] { return reloads == i; }));
    EXPECT_EQ(get(port(), content("header"), bearer(kOther)).status, has_other ? 200 : 401);
    ASSERT_TRUE(await_responses());
  }
  is_over = true;
}

TEST_F(Signals, TerminationCompletesWhatIsInProgress) {
  start();
  const std::string fields = " HTTP/1.1\r\nHost: localhost\r\n" + bearer(kToken) + "\r\n";
  // The header of `slow` is read before the gate closes.
  EXPECT_EQ(get(port(), "/v1/volumes/slow", bearer(kToken)).status, 200);
  start_clients(true);
  ASSERT_TRUE(await_responses());
  std::vector<Client> readers;
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back(port());
    readers.back().set_receive_buffer(64 * 1024);
    readers.back().send("GET /v1/volumes/large/" + large.content + "/file" + fields);
    EXPECT_EQ(readers.back().read(12), "HTTP/1.1 200");
  }
  gate().close();
  std::vector<Client> waiting;
  for (int i = 0; i < 3; ++i) {
    waiting.emplace_back(port());
    waiting.back().send("GET /v1/volumes/slow/" + alpha.content + "/file" + fields);
    gate().await(i + 1);
  }
  std::raise(SIGTERM);
  // The server closes connections between two requests, and completes the responses in progress.
  for (std::thread& thread : threads) thread.join();
  threads.clear();
  gate().open();
  for (Client& client : waiting) {
    const Answer answer = client.receive();
    EXPECT_EQ(answer.status, 200);
    EXPECT_TRUE(answer.body == text_of(alpha.file));
    EXPECT_TRUE(client.is_closed());
  }
  for (Client& client : readers) {
    std::string rest;
    for (std::string part; !(part = client.read(1 << 20)).empty();) rest += part;
    EXPECT_TRUE(rest.ends_with(text_of(large.file)));
  }
  readers.clear();
  waiting.clear();  // the server waits for its clients to close, up to 2 s
  server->wait();
}

}  // namespace
}  // namespace isosplat::server::test
