// Clients that take more than their share of the connections and of the threads that compute must
// not keep others from being served.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "server/limits/admission.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Clock = Admission::Clock;
using State = OpenConnection::State;
using Verdict = OpenConnection::Verdict;

/// Connections without sockets, and which of them were closed.
struct Connections {
  explicit Connections(Admission::Limits limits) : admission(limits) {}

  size_t open(const std::string& address, State state, uint64_t rate = 0) {
    now += milliseconds(1);
    auto place = admission.enter(address, now);
    if (!place || place->verdict() != Verdict::admitted) return SIZE_MAX;
    place->set_close([this, number = places.size()](State) { closed.push_back(number); });
    place->set_state(state, now);
    if (state == State::sending) place->set_rate(rate);
    places.push_back(std::move(place));
    return places.size() - 1;
  }
  std::vector<size_t> take_closed() {
    for (const size_t number : closed) places[number].reset();
    return std::exchange(closed, {});
  }

  Admission admission;
  Clock::time_point now{seconds(1000)};
  std::vector<std::unique_ptr<OpenConnection>> places;
  std::vector<size_t> closed;
};

constexpr Admission::Limits kFew{
    .connections = 4, .per_address = 0, .least_rate = 1000, .patience = milliseconds(2000)};

TEST(Admissions, TheClientWithTheMostLosesTheOneThatWaitsLongest) {
  Connections all(kFew);
  all.open("honest", State::waiting);
  for (int i = 0; i < 3; ++i) all.open("greedy", State::waiting);
  EXPECT_NE(all.open("another", State::serving), SIZE_MAX);
  EXPECT_EQ(all.take_closed(), std::vector<size_t>{1});
  // The greedy client opens more connections: each one closes another connection of this client.
  for (size_t i = 2; i < 20; ++i) {
    EXPECT_NE(all.open("greedy", State::waiting), SIZE_MAX);
    EXPECT_EQ(all.take_closed(), std::vector<size_t>{i == 2 ? 2 : i == 3 ? 3 : i + 1});
  }
}

TEST(Admissions, AFloodClosesAnEighthOfItsOwnConnectionsAtOnce) {
  Connections all({.connections = 32, .per_address = 0});
  for (int i = 0; i < 16; ++i) all.open("a", State::waiting);
  for (int i = 0; i < 16; ++i) all.open("b", State::waiting);
  EXPECT_NE(all.open("b", State::waiting), SIZE_MAX);
  EXPECT_EQ(all.take_closed(), (std::vector<size_t>{16, 17}));
  EXPECT_NE(all.open("b", State::waiting), SIZE_MAX);
  EXPECT_EQ(all.take_closed(), std::vector<size_t>{}) << "there is room for one more";
  EXPECT_NE(all.open("b", State::waiting), SIZE_MAX);
  EXPECT_EQ(all.take_closed(), (std::vector<size_t>{18, 19}));
}

TEST(Admissions, TheSlowestReaderIsClosedAfterItsMinimumTime) {
  Connections all(kFew);
  all.open("a", State::sending, 900);
  all.open("b", State::sending, 100);
  all.open("c", State::sending, 2000);
  all.open("d", State::serving);
  EXPECT_EQ(all.open("e", State::waiting), SIZE_MAX) << "they have only just begun";
  all.now += seconds(3);
  EXPECT_NE(all.open("e", State::sending, 5000), SIZE_MAX);
  EXPECT_EQ(all.take_closed(), std::vector<size_t>{1});
  EXPECT_NE(all.open("f", State::sending, 5000), SIZE_MAX);
  EXPECT_EQ(all.take_closed(), std::vector<size_t>{0});
  all.now += seconds(3);
  EXPECT_EQ(all.open("g", State::waiting), SIZE_MAX) << "all others are fast enough";
}

TEST(Admissions, FastReadersOfOneClientLeaveRoomForOthers) {
  Connections all(kFew);
  for (const uint64_t rate : {9'000'000, 5'000'000, 7'000'000}) all.open("a", State::sending, rate);
  all.open("b", State::sending, 1'000'000);
  EXPECT_NE(all.open("c", State::serving), SIZE_MAX);
  EXPECT_EQ(all.take_closed(), std::vector<size_t>{1});
  EXPECT_EQ(all.open("a", State::waiting), SIZE_MAX) << "a client does not displace other clients";
}

TEST(Admissions, ClientsBehindOneAddressAreDistinguished) {
  Connections all(kFew);
  for (const char* const client : {"one", "one", "two", "three"}) {
    all.places[all.open("proxy", State::waiting)]->set_client(client);
  }
  EXPECT_NE(all.open("proxy", State::serving), SIZE_MAX);
  EXPECT_EQ(all.take_closed(), std::vector<size_t>{0});
}

TEST(Admissions, AConnectionThatAProxyNamesCountsForItsClient) {
  Connections all({.connections = 8, .per_address = 1});
  for (int i = 0; i < 3; ++i) ASSERT_NE(all.open(Admission::kOfProxy, State::waiting), SIZE_MAX);
  all.places[0]->name("a");
  EXPECT_EQ(all.places[0]->verdict(), Verdict::admitted);
  all.places[1]->name("a");
  EXPECT_EQ(all.places[1]->verdict(), Verdict::too_many_from_one);
  EXPECT_EQ(all.open("a", State::waiting), SIZE_MAX);
  all.places[1].reset();
  all.places[0].reset();
  all.places[2]->name("a");
  EXPECT_EQ(all.places[2]->verdict(), Verdict::admitted);
}

TEST(Admissions, AnotherConnectionIsClosedForOneThatContinued) {
  Connections all(kFew);
  for (int i = 0; i < 4; ++i) all.open("a", State::waiting);
  EXPECT_NE(all.open("a", State::serving), SIZE_MAX);
  all.places[0]->keep();
  EXPECT_NE(all.open("a", State::serving), SIZE_MAX);
  EXPECT_EQ(all.closed.size(), 2u);
}

class Fairness : public ServerTest {
 protected:
  Fairness() {
    write_file(folder.path() / "large.isosplat", large.file);
    options.limits.idle_time = hours(1);
    options.limits.request_time = hours(1);
    options.limits.write_time = hours(1);
    options.limits.connections_per_address = 0;
    options.scan_interval = hours(1);
  }

  std::string large_file() const { return "/v1/volumes/large/" + large.content + "/file"; }

  /// A client that has begun to read a large response, and then stops reading.
  Client reader(const char* from = nullptr) {
    Client client(port(), from);
    client.set_receive_buffer(64 * 1024);
    client.send("GET " + large_file() + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(client.read(12), "HTTP/1.1 200");
    return client;
  }

  int status_from(const char* from) {
    return Client(port(), from).request("GET", "/healthz").status;
  }

  /// The bytes that the system buffers for the server's clients, in any state of their connections.
  uint64_t bytes_in_kernel() const {
    std::ifstream table("/proc/net/tcp");
    char hexadecimal[8];
    std::snprintf(hexadecimal, sizeof hexadecimal, ":%04X", port());
    uint64_t bytes = 0;
    for (std::string line; std::getline(table, line);) {
      std::istringstream fields(line);
      std::string slot, local, remote, state, queues;
      fields >> slot >> local >> remote >> state >> queues;
      constexpr const char* kListens = "0A";
      if (state == kListens || !local.ends_with(hexadecimal)) continue;
      bytes += std::stoull(queues.substr(0, 8), nullptr, 16);
    }
    return bytes;
  }

  const KnownStore large = make_store(3, {128, 128, 128}, 2'000'000);  // more than sockets buffer
};

TEST_F(Fairness, SlowReadersMakeRoom) {
  options.limits.connections = 4;
  options.limits.patience = milliseconds(100);
  start();
  std::vector<Client> slow;
  for (int i = 0; i < 4; ++i) slow.push_back(reader());
  EXPECT_TRUE(eventually([&] { return get(port(), "/healthz").status == 200; }));
}

TEST_F(Fairness, ManyConnectionsOfOneAddressMakeRoomForOthers) {
  options.limits.connections = 8;
  options.limits.patience = hours(1);
  start();
  Client honest(port(), "127.0.0.2");
  EXPECT_EQ(honest.request("GET", "/healthz").status, 200);
  std::vector<Client> greedy;
  for (int i = 0; i < 6; ++i) greedy.push_back(reader("127.0.0.3"));
  for (int i = 0; i < 12; ++i) {
    greedy.emplace_back(port(), "127.0.0.3");
    greedy.back().request("GET", "/healthz");
  }
  // For a moment, the server may be working for all of them. It then closes none.
  for (int i = 0; i < 8; ++i) {
    EXPECT_TRUE(eventually([&] { return status_from("127.0.0.4") == 200; })) << i;
  }
  EXPECT_EQ(honest.request("GET", "/healthz").status, 200) << "it has waited longest";
}

TEST_F(Fairness, UnreadBytesOfATimedOutReaderAreDropped) {
  {
    start();
    const Client slow = reader();
    ASSERT_TRUE(eventually([&] { return bytes_in_kernel() > 0; })) << "while it has time";
  }
  server.reset();
  options.limits.write_time = milliseconds(200);
  start();
  const Client slow = reader();
  EXPECT_TRUE(eventually([&] { return bytes_in_kernel() == 0; }));
  // The server also drops bytes that a client does not receive if it has closed its sending side,
  // or sends no more requests.
  Client ends = reader();
  ends.end_sending();
  Client idle(port());
  idle.set_receive_buffer(4096);
  idle.send("GET " + large_file() +
            " HTTP/1.1\r\nHost: localhost\r\nRange: bytes=0-150000\r\n\r\n");
  idle.end_sending();
  EXPECT_EQ(idle.read(12), "HTTP/1.1 206");
  EXPECT_TRUE(eventually([&] { return bytes_in_kernel() == 0; }));
}

TEST_F(Fairness, AReaderThatContinuesReceivesTheRest) {
  options.limits.write_time = milliseconds(400);
  options.limits.idle_time = milliseconds(400);
  start();
  for (const char* const fields : {"", "Connection: close\r\n"}) {
    // If the test itself was delayed for that long, it is repeated.
    size_t most = 0;
    for (int attempt = 0; attempt < 20 && most < 300'000; ++attempt) {
      Client patient(port());
      patient.set_receive_buffer(16 * 1024);
      patient.send("GET " + large_file() + " HTTP/1.1\r\nHost: localhost\r\n" + fields +
                   "Range: bytes=0-299999\r\n\r\n");
      patient.end_sending();
      size_t all = 0;
      for (std::string part; !(part = patient.read(10'000)).empty(); all += part.size()) {
        std::this_thread::sleep_for(milliseconds(30));
      }
      most = std::max(most, all);
    }
    EXPECT_GE(most, 300'000u) << fields;
  }
}

TEST_F(Fairness, WithoutDescriptorsWaitingConnectionsMakeRoom) {
  start();
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  uint64_t end = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    end = std::max<uint64_t>(end, std::stoull(entry.path().filename().string()) + 1);
  }
  std::vector<int> taken;
  const auto set_limit = [&](uint64_t descriptors) {
    const rlimit few{descriptors, before.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &few);
  };
  set_limit(end);
  for (int file = 0; (file = ::open("/dev/null", O_RDONLY | O_CLOEXEC)) >= 0;)
    taken.push_back(file);
  set_limit(end + 5);  // both ends of two connections, and the client's end of a third
  std::vector<Client> clients;
  for (int i = 0; i < 3; ++i) {
    // The server's own threads may have a file open for a moment.
    EXPECT_TRUE(eventually([&] {
      try {
        clients.emplace_back(port());
      } catch (const std::runtime_error&) {
        return false;
      }
      return true;
    }));
    EXPECT_EQ(clients.back().request("GET", "/healthz").status, 200);
  }
  clients.clear();
  for (const int file : taken) ::close(file);
  ::setrlimit(RLIMIT_NOFILE, &before);
}

TEST_F(Fairness, TooFewDescriptorsAreReportedAtTheStart) {
  rlimit now{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &now), 0);
  if (now.rlim_max > 1'000'000'000) GTEST_SKIP() << "no such limit";
  start();
  EXPECT_FALSE(log_mentions("open files"));
  server.reset();
  options.limits.connections = static_cast<uint32_t>(now.rlim_max);
  start();
  EXPECT_TRUE(will_log("the system allows " + std::to_string(now.rlim_max) + " open files"));
  EXPECT_EQ(get(port(), "/healthz").status, 200);
}

}  // namespace
}  // namespace isosplat::server::test
