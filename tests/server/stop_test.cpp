// Starting, and stopping with responses in progress.

#include <gtest/gtest.h>

#include <csignal>
#include <thread>

#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class Stop : public ServerTest {
 protected:
  void start_with_large_store() {
    large = make_store(3, {128, 128, 128}, 2'000'000);
    write_file(folder.path() / "large.isosplat", large.file);
    start();
  }

  /// A client that has begun to read the large store and waits.
  Client reader() {
    Client client(port());
    client.set_receive_buffer(64 * 1024);
    client.send("GET /v1/volumes/large/" + large.content +
                "/file HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return client;
  }

  bool is_refusing() {
    try {
      Client client(port());
      return client.request("GET", "/healthz").status == 0;
    } catch (const std::runtime_error&) {
      return true;
    }
  }

  KnownStore large;  ///< larger than the buffers of sockets
};

TEST_F(Stop, ResponsesInProgressEndAndIdleConnectionsClose) {
  options.limits.stop_time = seconds(60);
  start_with_large_store();
  Client idle(port());
  EXPECT_EQ(idle.request("GET", "/healthz").status, 200);
  Client client = reader();
  const std::string begin = client.read(12);
  server->stop();
  EXPECT_TRUE(idle.is_closed());
  EXPECT_TRUE(eventually([&] { return is_refusing(); }));
  std::string all = begin;
  for (std::string part; !(part = client.read(1 << 20)).empty();) all += part;
  EXPECT_TRUE(all.ends_with(text_of(large.file)));
  server->wait();
}

TEST_F(Stop, ASignalDuringATransfer) {
  options.handle_signals = true;
  options.limits.stop_time = seconds(60);
  start_with_large_store();
  Client client = reader();
  const std::string begin = client.read(12);
  std::raise(SIGTERM);
  EXPECT_TRUE(eventually([&] { return is_refusing(); }));
  std::string all = begin;
  for (std::string part; !(part = client.read(1 << 20)).empty();) all += part;
  EXPECT_TRUE(all.ends_with(text_of(large.file)));
  server->wait();
  EXPECT_TRUE(will_log("stopping"));
}

TEST_F(Stop, ASecondSignalDropsResponsesInProgress) {
  std::signal(SIGINT, SIG_DFL);  // shells make background jobs ignore it
  options.handle_signals = true;
  options.limits.stop_time = seconds(600);
  start_with_large_store();
  Client client = reader();
  client.read(12);
  std::raise(SIGINT);
  EXPECT_TRUE(will_log("stopping"));
  std::raise(SIGINT);
  server->wait();
}

TEST_F(Stop, TheDeadlineDropsResponsesInProgress) {
  options.limits.stop_time = milliseconds(300);
  start_with_large_store();
  Client client = reader();
  client.read(12);
  Client half(port());
  half.send("GET /hea");
  server->stop();
  server->wait();  // needs a deadline, since the client receives nothing
  size_t received = 12;
  for (std::string part; !(part = client.read(1 << 20)).empty();) received += part.size();
  EXPECT_LT(received, large.file.size());
}

TEST_F(Stop, MayBeRequestedAgain) {
  start();
  server->stop();
  server->stop();
  server->wait();
  server->wait();
  server->stop();
}

TEST_F(Stop, AtOnceAfterTheStart) {
  for (int i = 0; i < 20; ++i) {
    start();
    Client client(port());
    client.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
    server.reset();
  }
}

TEST_F(Stop, APortInUseIsAnError) {
  start();
  ServerOptions second = options;
  second.port = port();
  const auto started = Server::start(second);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().status, Status::io_error);
  EXPECT_NE(started.error().message.find(std::to_string(port())), std::string::npos);
}

TEST_F(Stop, UnusableHostsAndStoresAreErrors) {
  options.host = "no-such-host.invalid";
  EXPECT_EQ(Server::start(options).error().status, Status::io_error);
  options.host = "192.0.2.1";  // a documentation address: none of this machine's
  EXPECT_EQ(Server::start(options).error().status, Status::io_error);
  options.host = "127.0.0.1";
  options.stores = {folder.path() / "nothing"};
  EXPECT_EQ(Server::start(options).error().status, Status::io_error);
}

TEST_F(Stop, LocalhostAndAllInterfaces) {
  for (const char* host : {"localhost", "0.0.0.0", "::"}) {
    options.host = host;
    options.cross_origin = CrossOrigin{};
    auto started = Server::start(options);
    if (!started && std::string(host) == "::") continue;  // a machine without IPv6
    ASSERT_TRUE(started) << started.error().message;
    EXPECT_EQ((*started)->url(), "http://localhost:" + std::to_string((*started)->port()) + "/");
    EXPECT_EQ(get((*started)->port(), "/healthz").status, 200) << host;
  }
}

TEST_F(Stop, AccessLogHasOneLinePerResponse) {
  std::mutex mutex;
  std::vector<std::string> lines;
  options.access_log = [&](std::string_view line) {
    const std::lock_guard lock(mutex);
    lines.emplace_back(line);
  };
  start();
  Client client(port());
  client.request("GET", "/healthz");
  client.request("GET", "/v1/volumes/x\"y");
  client.send("nonsense\r\n\r\n");
  client.receive();
  server.reset();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(lines[0].starts_with("127.0.0.1 GET /healthz 200 ")) << lines[0];
  EXPECT_TRUE(lines[1].starts_with("127.0.0.1 GET /v1/volumes/x\\x22y 400 ")) << lines[1];
  EXPECT_NE(lines[2].find(" 400 "), std::string::npos) << lines[2];
  for (const std::string& line : lines) EXPECT_EQ(line.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace isosplat::server::test
