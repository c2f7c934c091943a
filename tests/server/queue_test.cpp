// The order of clients on the threads that compute: a client with many requests does not make
// others wait, and nothing is computed for clients that have disconnected.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "native/builder/array_source.h"
#include "server/limits/fair_queue.h"
#include "server/routes/router.h"
#include "server/routes/work_turn.h"
#include "shared/system/store_file/store_file.h"
#include "tests/server/faulty_disk.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Queue = FairQueue<const std::string>;

std::string serve(Queue& queue, uint64_t cost = 1) {
  const std::string item = *queue.pop();
  queue.charge(item.substr(0, 1), cost);
  return item;
}

TEST(FairQueues, ServeClientsInTurn) {
  const std::string a1 = "a1", a2 = "a2", a3 = "a3", b1 = "b1", c1 = "c1", b2 = "b2";
  Queue queue;
  for (const std::string* item : {&a1, &a2, &a3}) queue.push("a", item);
  queue.push("b", &b1);
  queue.push("c", &c1);
  queue.push("b", &b2);
  EXPECT_EQ(queue.size(), 6u);
  EXPECT_EQ(queue.size_of("a"), 3u);
  std::string order;
  while (queue.size() > 0) order += serve(queue);
  EXPECT_EQ(order, "a1b1c1a2b2a3");
}

TEST(FairQueues, ChargeClientsForTheCostOfTheirTurns) {
  const std::string a1 = "a1", a2 = "a2", b1 = "b1", b2 = "b2", b3 = "b3", c1 = "c1", c2 = "c2";
  Queue queue;
  for (const std::string* item : {&a1, &a2}) queue.push("a", item);
  for (const std::string* item : {&b1, &b2, &b3}) queue.push("b", item);
  EXPECT_EQ(serve(queue, 20), "a1");
  EXPECT_EQ(serve(queue, 8), "b1");
  EXPECT_EQ(serve(queue, 8), "b2");
  // A new client has no credit for the time before its first request.
  for (const std::string* item : {&c1, &c2}) queue.push("c", item);
  EXPECT_EQ(serve(queue, 10), "c1");
  EXPECT_EQ(serve(queue, 8), "b3");
  EXPECT_EQ(serve(queue, 10), "c2");
  EXPECT_EQ(serve(queue), "a2");
}

TEST(FairQueues, RemoveItems) {
  const std::string a1 = "a1", a2 = "a2", b1 = "b1";
  Queue queue;
  queue.push("a", &a1);
  queue.push("a", &a2);
  queue.push("b", &b1);
  EXPECT_EQ(*queue.most_of_one().back(), "a2");
  EXPECT_TRUE(queue.remove("a", &a1));
  EXPECT_FALSE(queue.remove("a", &a1));
  EXPECT_FALSE(queue.remove("c", &a1));
  EXPECT_EQ(serve(queue), "a2");
  EXPECT_EQ(serve(queue), "b1");
  EXPECT_EQ(queue.size(), 0u);
}

class SampleQueue : public ServerTest {
 protected:
  SampleQueue() {
    options.threads = 1;
    options.limits.connections_per_address = 0;
    VolumeGrid grid;
    grid.voxels = {70, 40, 40};
    std::vector<uint8_t> voxels;
    for (int32_t i = 0; i < 70 * 40 * 40; ++i) voxels.push_back(static_cast<uint8_t>(i % 70));
    // The disk of files named "slow…" waits for the gate.
    for (const std::string name : {"points", "slow-points"}) {
      const auto path = folder.path() / (name + ".isosplat");
      const auto built = build_store_file<uint8_t>(grid, voxels, path);
      EXPECT_TRUE(built) << built.error().message;
      target_of[name] = "/v1/volumes/" + name + "/" + (*StoreFile::open(path))->content() +
                        "/samples?isovalue=60.5";
    }
  }
  ~SampleQueue() override { gate().open(); }

  static uint32_t threads() { return std::max(1u, std::thread::hardware_concurrency() / 2); }

  std::string request_for(const std::string& name, const std::string& fields = {}) const {
    return "GET " + target_of.at(name) + " HTTP/1.1\r\nHost: localhost\r\n" + fields + "\r\n";
  }

  uint64_t metric(const std::string& name) const {
    const std::string text = get(port(), "/metrics", metrics_fields).body;
    const size_t at = text.find("\n" + name + " ");
    return at == std::string::npos ? UINT64_MAX : std::stoull(text.substr(at + name.size() + 2));
  }
  bool has(const std::string& name, uint64_t value) const {
    return eventually([&] { return metric(name) == value; });
  }

  /// Keeps the threads that compute waiting for the gate.
  void hold_threads() {
    gate().close();
    Client client(port(), "127.0.0.9");
    gate().open();
    ASSERT_EQ(client.request("GET", target_of["slow-points"], metrics_fields).status, 200);
    const int before = gate().reads();
    ASSERT_EQ(client.request("GET", target_of["slow-points"], metrics_fields).status, 200);
    // A thread for disks reads the chunks. A thread that computes reads them twice: to count the
    // points, and for a piece of the body.
    const int chunks = (gate().reads() - before) / 3;
    ASSERT_GT(chunks, 0);
    for (uint32_t i = 0; i < threads(); ++i) {
      gate().close_after(chunks);
      holders.emplace_back(port(), "127.0.0.9");
      holders.back().send(request_for("slow-points", metrics_fields));
      gate().await(static_cast<int>(i) + 1);
      ASSERT_TRUE(has(kWaiting, i + 1));
    }
  }

  std::vector<Client> clients_from(const char* address, size_t count,
                                   const std::string& fields = {}) {
    std::vector<Client> clients;
    for (size_t i = 0; i < count; ++i) {
      clients.emplace_back(port(), address);
      clients.back().send(request_for("points", fields));
    }
    return clients;
  }

  static constexpr const char* kWaiting = "isosplat_computations_waiting";
  std::map<std::string, std::string> target_of;
  std::string metrics_fields;
  std::vector<Client> holders;
};

TEST_F(SampleQueue, OneAddressDoesNotOccupyTheThreads) {
  start();
  ASSERT_NO_FATAL_FAILURE(hold_threads());
  // The maximum number of requests of one client, and more: the additional ones are refused, and a
  // request of another client is not.
  const size_t most = size_t{options.limits.waiting_computations_of_one} * threads();
  std::vector<Client> greedy = clients_from("127.0.0.3", most);
  ASSERT_TRUE(has(kWaiting, threads() + most));
  Client refused(port(), "127.0.0.3");
  const Answer answer = refused.request("GET", target_of["points"]);
  EXPECT_EQ(answer.status, 503);
  EXPECT_EQ(answer.header("retry-after"), "1");
  EXPECT_EQ(metric("isosplat_computations_refused_total"), 1u);
  std::vector<Client> other = clients_from("127.0.0.4", 1);
  ASSERT_TRUE(has(kWaiting, threads() + most + 1));
  gate().open();
  EXPECT_EQ(other[0].receive().status, 200);
  for (Client& client : greedy) EXPECT_EQ(client.receive().status, 200);
}

TEST_F(SampleQueue, AnotherClientIsServedDespiteContinuousRequestsOfOneAddress) {
  start();
  std::atomic<bool> is_over{false};
  std::atomic<uint64_t> greedy{0};
  std::vector<std::thread> loops;
  for (int i = 0; i < 40; ++i) {
    loops.emplace_back([&] {
      Client client(port(), "127.0.0.3");
      while (!is_over) {
        if (client.request("GET", target_of["points"]).status == 200) ++greedy;
      }
    });
  }
  EXPECT_TRUE(eventually([&] { return greedy > 40; }));
  const uint64_t before = greedy;
  Client client(port(), "127.0.0.4");
  constexpr int kAnswers = 30;
  for (int i = 0; i < kAnswers; ++i) {
    EXPECT_EQ(client.request("GET", target_of["points"]).status, 200) << i;
  }
  // Clients take turns: each response takes two turns. Between them, only some of the other
  // requests are served, not all 40.
  EXPECT_LT(greedy - before, uint64_t{kAnswers} * 20);
  is_over = true;
  for (std::thread& loop : loops) loop.join();
}

TEST_F(SampleQueue, WhenItIsFullTheClientWithTheMostRequestsLosesOne) {
  options.limits.waiting_computations = 4;
  start();
  ASSERT_NO_FATAL_FAILURE(hold_threads());
  const size_t most = size_t{4} * threads();
  std::vector<Client> greedy = clients_from("127.0.0.3", most);
  ASSERT_TRUE(has(kWaiting, threads() + most));
  std::vector<Client> other = clients_from("127.0.0.4", 1);
  EXPECT_TRUE(has("isosplat_computations_refused_total", 1));
  EXPECT_EQ(metric(kWaiting), threads() + most);
  gate().open();
  EXPECT_EQ(other[0].receive().status, 200);
  size_t refused = 0;
  for (Client& client : greedy) refused += client.receive().status == 503 ? 1 : 0;
  EXPECT_EQ(refused, 1u);
}

TEST_F(SampleQueue, RequestsOfDisconnectedClientsAreRemoved) {
  start();
  ASSERT_NO_FATAL_FAILURE(hold_threads());
  const uint64_t begun = metric("isosplat_computations_total");
  const size_t count = 5;
  for (const bool by_reset : {true, false}) {
    std::vector<Client> leaving = clients_from("127.0.0.3", count);
    ASSERT_TRUE(has(kWaiting, threads() + count));
    for (Client& client : leaving) {
      if (by_reset) client.reset();
    }
    leaving.clear();
    EXPECT_TRUE(has(kWaiting, threads()));
    EXPECT_EQ(metric("isosplat_work_cancelled_total"), by_reset ? count : 2 * count);
  }
  // Requests whose connection is reset at once do not stay in the queue.
  const size_t most = size_t{options.limits.waiting_computations_of_one} * threads();
  for (size_t i = 0; i < 3 * most; ++i) clients_from("127.0.0.3", 1)[0].reset();
  EXPECT_TRUE(has(kWaiting, threads()));
  std::vector<Client> other = clients_from("127.0.0.3", 1);
  EXPECT_EQ(metric("isosplat_computations_total"), begun) << "nothing was computed for them";
  gate().open();
  EXPECT_EQ(other[0].receive().status, 200);
}

TEST_F(SampleQueue, WorkThatHasBegunEndsWithItsClient) {
  start();
  ASSERT_NO_FATAL_FAILURE(hold_threads());
  const uint64_t begun = metric("isosplat_computations_total");
  holders.clear();
  gate().open();
  EXPECT_TRUE(has(kWaiting, 0));
  EXPECT_TRUE(has("isosplat_work_cancelled_total", threads()));
  EXPECT_EQ(metric("isosplat_computations_total"), begun) << "no further turn";
}

TEST_F(SampleQueue, EachTokenCountsAsAClient) {
  write_file(folder.path() / "tokens",
             "0123456789abcdef-one name=one *\n0123456789abcdef-two name=two *\nanyone points\n");
  options.token_file = folder.path() / "tokens";
  metrics_fields = "Authorization: Bearer 0123456789abcdef-one\r\n";
  const std::string two = "Authorization: Bearer 0123456789abcdef-two\r\n";
  start();
  ASSERT_NO_FATAL_FAILURE(hold_threads());
  const size_t most = size_t{options.limits.waiting_computations_of_one} * threads();
  // One address has three clients: requests without a token, and two tokens.
  std::vector<std::vector<Client>> waiting;
  waiting.push_back(clients_from("127.0.0.3", most));
  ASSERT_TRUE(has(kWaiting, threads() + most));
  waiting.push_back(clients_from("127.0.0.3", most, two));
  ASSERT_TRUE(has(kWaiting, threads() + 2 * most));
  Client refused(port(), "127.0.0.4");
  EXPECT_EQ(refused.request("GET", target_of["points"], two).status, 503) << "another address";
  EXPECT_NE(refused.request("HEAD", "/healthz").status, 503);
  gate().open();
  for (auto& clients : waiting) {
    for (Client& client : clients) EXPECT_EQ(client.receive().status, 200);
  }
}

TEST_F(SampleQueue, PointsAreCountedInTurns) {
  VolumeGrid grid;
  grid.voxels = {128, 128, 128};
  std::vector<uint8_t> voxels;
  for (int32_t z = 0; z < 128; ++z) {
    for (int32_t i = 0; i < 128 * 128; ++i) {
      voxels.push_back(static_cast<uint8_t>((i * 7 + i / 128 * 13 + z * 29) % 200));
    }
  }
  const auto path = folder.path() / "noise.isosplat";
  ASSERT_TRUE(build_store_file<uint8_t>(grid, voxels, path));
  const auto ignore = [](std::string_view) {};
  Catalog catalog({folder.path()}, ignore);
  StorePool stores({.stores = 1, .directory_bytes = 1 << 20}, ignore);
  ScenePool scenes({}, ScenePool::OutsideLinks::followed, ignore);
  catalog.scan();
  const Router router(catalog, stores, scenes, RouterLimits{});
  const std::string target = "/v1/volumes/noise/" + (*StoreFile::open(path))->content() +
                             "/samples?isovalue=60.5&fields=normals";
  Request request;
  request.method = Method::get;
  request.target = target;
  RoutedCall call = router.route(request);
  WorkTurn turn;
  int counting = 0, reading = 0;
  do {
    turn.is_unfinished = false;
    call.respond(ThreadKind::disk, nullptr, &turn);
    ++reading;
  } while (turn.is_unfinished);
  Response response;
  do {
    turn.is_unfinished = false;
    response = call.respond(ThreadKind::computing, nullptr, &turn);
    ++counting;
  } while (turn.is_unfinished && counting < 100);
  EXPECT_EQ(counting, 2) << "127³ cells, 2²⁰ in a turn";
  EXPECT_GE(reading, 1);
  const Response at_once = router.respond(request);
  EXPECT_EQ(at_once.status, 200);
  EXPECT_EQ(response.headers, at_once.headers) << "with the number of points";
}

}  // namespace
}  // namespace isosplat::server::test
