// Reads that wait for a disk: they delay no other connection.
//
// Files named "slow…" are those of a slow disk (faulty_disk.h): a read waits until the test opens
// the gate.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <thread>

#include "native/builder/array_source.h"
#include "server/routes/router.h"
#include "server/routes/work_turn.h"
#include "shared/system/store_file/store_file.h"
#include "tests/server/faulty_disk.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

class SlowDisk : public ServerTest {
 protected:
  SlowDisk() {
    options.threads = 1;  // so the other connections use the same thread
    options.disk_threads = 2;
    write_file(folder.path() / "slow.isosplat", slow.file);
  }
  ~SlowDisk() override {
    first_bad_byte() = kNoBadBytes;
    gate().open();
  }

  std::string slow_content(const std::string& rest) const {
    return "/v1/volumes/slow/" + slow.content + "/" + rest;
  }
  /// Starts the server, and opens both stores: later requests read chunks and pages only.
  void start_with_open_stores() {
    start();
    for (const char* const name : {"alpha", "slow"}) {
      EXPECT_EQ(get(port(), std::string("/v1/volumes/") + name).status, 200);
    }
  }
  bool has_metric(const std::string& line) const {
    return get(port(), "/metrics").body.find("\n" + line + "\n") != std::string::npos;
  }
  static std::string request_for(const std::string& target) {
    return "GET " + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  }
  /// A chunk of the store with cells: the first one after `skipped` others.
  const KnownChunk& chunk_of(const KnownStore& store, int skipped = 0) const {
    for (const KnownChunk& chunk : store.chunks) {
      if (chunk.cells > 0 && skipped-- == 0) return chunk;
    }
    throw std::runtime_error("no chunk");
  }

  /// Writes a store with a surface at the isovalue 60.5. Returns the path of its points.
  std::string write_points(const std::string& name) const {
    VolumeGrid grid;
    grid.voxels = {70, 40, 40};
    std::vector<uint8_t> voxels;
    for (int32_t i = 0; i < 70 * 40 * 40; ++i) voxels.push_back(static_cast<uint8_t>(i % 70));
    const auto path = folder.path() / (name + ".isosplat");
    const auto built = build_store_file<uint8_t>(grid, voxels, path);
    EXPECT_TRUE(built) << built.error().message;
    return "/v1/volumes/" + name + "/" + (*StoreFile::open(path))->content() +
           "/samples?isovalue=60.5";
  }
  static uint32_t computing_threads() {
    return std::max(1u, std::thread::hardware_concurrency() / 2);
  }

  const KnownStore slow = make_store(7);
};

TEST_F(SlowDisk, DelaysOnlyClientsThatReadFromIt) {
  start_with_open_stores();
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
  start_with_open_stores();
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

TEST_F(SlowDisk, OpeningAStoreDelaysNobodyElse) {
  start();
  EXPECT_EQ(get(port(), "/v1/volumes/alpha").status, 200);
  ASSERT_TRUE(will_log("volume slow: "));
  gate().close();
  // The server reads its header when a client requests it.
  Client waiting(port());
  waiting.send(request_for(slow_content("header")));
  gate().await(1);
  EXPECT_EQ(get(port(), content("header")).status, 200);
  EXPECT_EQ(get(port(), "/v1/volumes").status, 200) << "what lists say is in memory";
  EXPECT_EQ(get(port(), "/v1/volumes?query=test%207").status, 200);
  gate().open();
  EXPECT_EQ(waiting.receive().status, 200);
}

TEST_F(SlowDisk, AStopWaitsForItsReads) {
  options.limits.stop_time = std::chrono::seconds(60);
  start_with_open_stores();
  gate().close();
  Client waiting(port());
  waiting.send(request_for(slow_content("chunks/" + place_of(chunk_of(slow)))));
  gate().await(1);
  server->stop();
  gate().open();
  EXPECT_EQ(waiting.receive().body, text_of(chunk_of(slow).bytes));
  server->wait();
}

TEST_F(SlowDisk, AChunkThatWasSentIsInMemory) {
  start_with_open_stores();
  const std::string target = slow_content("chunks/" + place_of(chunk_of(slow)));
  EXPECT_EQ(get(port(), target).status, 200);
  gate().close();
  EXPECT_EQ(get(port(), target).body, text_of(chunk_of(slow).bytes));
}

TEST_F(SlowDisk, AStopDropsQueuedReads) {
  options.limits.stop_time = std::chrono::milliseconds(50);
  start_with_open_stores();
  const std::string target = slow_content("chunks/" + place_of(chunk_of(slow)));
  const std::string neighbour = slow_content("chunks/" + place_of(chunk_of(slow, 1)));
  EXPECT_EQ(get(port(), neighbour).status, 200) << "its directory page is in memory";
  gate().close();
  const int before = gate().reads();
  std::vector<Client> waiting;
  for (int i = 0; i < 20; ++i) {
    waiting.emplace_back(port());
    waiting.back().send(request_for(target));
  }
  ASSERT_TRUE(eventually([&] { return has_metric("isosplat_disk_reads_waiting 20"); }));
  server->stop();
  for (Client& client : waiting) EXPECT_TRUE(client.is_closed());
  gate().open();
  server->wait();
  EXPECT_EQ(gate().reads() - before, 2) << "those that had begun";
}

TEST_F(SlowDisk, PointsOfOtherStoresDoNotWait) {
  const std::string target = write_points("slow-points"), other = write_points("points");
  start_with_open_stores();
  const Answer before = get(port(), target);
  EXPECT_EQ(before.status, 200);
  EXPECT_GT(before.body.size(), 30'000u);
  EXPECT_EQ(get(port(), other).body, before.body) << "both stores are open";
  gate().close();
  std::vector<Client> waiting;
  for (uint32_t i = 0; i <= computing_threads(); ++i) {
    waiting.emplace_back(port());
    waiting.back().send(request_for(target));
  }
  gate().await(2);
  EXPECT_EQ(get(port(), other).body, before.body);
  gate().open();
  for (Client& client : waiting) {
    const Answer answer = client.receive();
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body, before.body);
  }
}

TEST_F(SlowDisk, ComputationsAreRefusedWhenManyWait) {
  options.limits.waiting_computations = 0;
  const std::string target = write_points("slow-points");
  start_with_open_stores();
  EXPECT_EQ(get(port(), target).status, 200) << "its directory page is in memory";
  const int before = gate().reads();
  EXPECT_EQ(Client(port()).request("HEAD", target).status, 200);
  // A thread for disks reads the chunks. Then a thread that computes reads them, and waits here.
  const int chunks = (gate().reads() - before) / 2;
  ASSERT_GT(chunks, 0);
  std::vector<Client> computing;
  for (uint32_t i = 0; i < computing_threads(); ++i) {
    gate().close_after(chunks);
    computing.emplace_back(port());
    computing.back().send(request_for(target));
    gate().await(static_cast<int>(i) + 1);
    const std::string number = std::to_string(i + 1);
    ASSERT_TRUE(eventually([&] { return has_metric("isosplat_computations_waiting " + number); }));
  }
  for (const char* method : {"GET", "HEAD"}) {
    const Answer refused = Client(port()).request(method, target);
    EXPECT_EQ(refused.status, 503) << method;
    EXPECT_EQ(refused.header("retry-after"), "1");
    EXPECT_EQ(refused.body.find("busy") == std::string::npos, method == std::string("HEAD"));
  }
  EXPECT_EQ(get(port(), content("chunks/" + place_of(chunk_of(alpha)))).status, 200);
  gate().open();
  for (Client& client : computing) EXPECT_NE(client.receive().status, 503);
  EXPECT_TRUE(eventually([&] { return get(port(), target).status != 503; }));
}

TEST_F(SlowDisk, ASearchReadsFewHeadersAtATime) {
  constexpr int kStores = 100, kDamaged = 5;
  const std::filesystem::path many = folder.path() / "many";
  std::filesystem::create_directories(many);
  for (int i = 0; i < kStores + kDamaged; ++i) {
    const char* const name = i < kStores ? "slow-" : "slow-damaged-disk-";
    std::filesystem::create_hard_link(folder.path() / "slow.isosplat",
                                      many / (name + std::to_string(i) + ".isosplat"));
  }
  const int before_open = gate().reads();
  ASSERT_TRUE(StoreFile::open(many / "slow-0.isosplat"));
  const int reads_of_header = gate().reads() - before_open;
  first_bad_byte() = 0;
  // This test has no server, since a thread of the server reads headers as well.
  const auto ignore = [](std::string_view) {};
  Catalog catalog({many}, ignore);
  StorePool stores({.stores = 1, .directory_bytes = 1 << 20}, ignore);
  ScenePool scenes({}, ScenePool::OutsideLinks::followed, ignore);
  catalog.scan();
  const Router router(catalog, stores, scenes, RouterLimits{});
  for (const bool is_search : {true, false}) {
    const std::string target =
        std::string("/v1/volumes?limit=1000") + (is_search ? "&query=test%207" : "");
    Request request;
    request.method = Method::get;
    request.target = target;
    Response response;
    RoutedCall call = router.route(request);
    WorkTurn turn;
    int turns = 0;
    do {
      turn.is_unfinished = false;
      const int before = gate().reads();
      response = call.respond(ThreadKind::disk, nullptr, &turn);
      EXPECT_LE(gate().reads() - before, static_cast<int>(kHeadersPerTurn) * reads_of_header);
      ++turns;
    } while (turn.is_unfinished && turns < 100);
    // Each request tries once more to read the headers that failed.
    EXPECT_EQ(turns, is_search ? (kStores + kDamaged + 15) / 16 : 1);
    const std::string total = std::to_string(kStores + (is_search ? 0 : kDamaged));
    EXPECT_TRUE(response.text.starts_with("{\"total\":" + total + ",")) << response.text;
    EXPECT_EQ(response.text, router.respond(request).text);
  }
  first_bad_byte() = kNoBadBytes;
}

TEST_F(SlowDisk, ReadinessReadsFewHeadersAtATime) {
  constexpr int kTried = 64, kDamaged = 70;
  const std::filesystem::path many = folder.path() / "many";
  std::filesystem::create_directories(many);
  const auto add = [&](const std::string& name) {
    std::filesystem::create_hard_link(folder.path() / "slow.isosplat", many / (name + ".isosplat"));
  };
  for (int i = 0; i < kDamaged; ++i) {
    add((i < 20 ? "slow-a-damaged-disk-" : "slow-c-damaged-disk-") + std::to_string(i));
  }
  first_bad_byte() = 0;
  const int before_open = gate().reads();
  ASSERT_FALSE(StoreFile::open(many / "slow-a-damaged-disk-0.isosplat"));
  const int reads_of_header = gate().reads() - before_open;
  ASSERT_GT(reads_of_header, 0);
  const auto ignore = [](std::string_view) {};
  Catalog catalog({many}, ignore);
  StorePool stores({.stores = 1, .directory_bytes = 1 << 20}, ignore);
  ScenePool scenes({}, ScenePool::OutsideLinks::followed, ignore);
  Router router(catalog, stores, scenes, RouterLimits{});
  Request request;
  request.method = Method::get;
  request.target = "/readyz";
  int reads = 0;
  const auto respond = [&](int most_turns) {
    catalog.scan();
    router.count_files();
    const int first = gate().reads();
    Response response;
    RoutedCall call = router.route(request);
    WorkTurn turn;
    for (int turns = 1;; ++turns) {
      turn.is_unfinished = false;
      const int before = gate().reads();
      response = call.respond(ThreadKind::disk, nullptr, &turn);
      EXPECT_LE(gate().reads() - before, static_cast<int>(kHeadersPerTurn) * reads_of_header);
      if (!turn.is_unfinished || turns == 100) {
        EXPECT_EQ(turns, most_turns);
        break;
      }
    }
    reads = gate().reads() - first;
    return response.status;
  };
  EXPECT_EQ(respond(kTried / 16), 503);
  EXPECT_EQ(reads, kTried * reads_of_header);
  add("slow-d");
  EXPECT_EQ(respond(kTried / 16), 503) << "is not among those that are tried";
  add("slow-b");
  EXPECT_EQ(respond(2), 200) << "the 21st";
  EXPECT_EQ(respond(1), 200);
  EXPECT_EQ(reads, 0) << "its header is known";
  first_bad_byte() = kNoBadBytes;
}

TEST_F(SlowDisk, SearchesOfUnreadStoresDelayNoReadsOfOthers) {
  constexpr int kSearches = 16;
  options.disk_threads = kSearches;
  write_file(folder.path() / "cold.isosplat", alpha.file);
  for (int i = 0; i < 40; ++i) {
    std::filesystem::create_hard_link(folder.path() / "slow.isosplat",
                                      folder.path() / ("slow-" + std::to_string(i) + ".isosplat"));
  }
  gate().close();  // also for the thread that reads headers ahead
  start();
  EXPECT_EQ(get(port(), "/v1/volumes/cold").status, 200);
  std::vector<Client> searching;
  for (int i = 0; i < kSearches; ++i) {
    searching.emplace_back(port());
    searching.back().send(request_for("/v1/volumes?query=no-such-title"));
  }
  ASSERT_TRUE(eventually([&] { return has_metric("isosplat_disk_reads_waiting 16"); }));
  for (const KnownChunk& chunk : alpha.chunks) {
    if (chunk.cells == 0) continue;
    const Answer answer =
        get(port(), "/v1/volumes/cold/" + alpha.content + "/chunks/" + place_of(chunk));
    EXPECT_EQ(answer.status, 200);
    EXPECT_TRUE(answer.body == text_of(chunk.bytes)) << place_of(chunk);
  }
  EXPECT_EQ(get(port(), "/readyz").status, 200) << "one store is known";
  EXPECT_TRUE(has_metric("isosplat_disk_reads_waiting 16"));
  gate().open();
  for (Client& client : searching) {
    EXPECT_TRUE(client.receive().body.starts_with("{\"total\":0,"));
  }
}

TEST_F(SlowDisk, PointsWhoseFirstChunkCannotBeReadAreAnError) {
  const std::string target = write_points("slow-damaged-disk-points");
  start_with_open_stores();
  const Answer whole = get(port(), target);
  EXPECT_EQ(whole.status, 200);
  const int before = gate().reads();
  EXPECT_EQ(Client(port()).request("HEAD", target).status, 200);
  gate().close_after(gate().reads() - before);  // these reads count the points
  Client client(port());
  client.send(request_for(target));
  gate().await(1);
  first_bad_byte() = 0;
  gate().open();
  const Answer answer = client.receive();
  EXPECT_EQ(answer.status, 500);
  EXPECT_NE(answer.body.find(R"("status":"io_error")"), std::string::npos) << answer.body;
  EXPECT_EQ(answer.header("x-isosplat-points"), "");
  first_bad_byte() = kNoBadBytes;
  client.send(request_for(target));
  EXPECT_TRUE(client.receive().body == whole.body);
}

TEST_F(SlowDisk, AClientThatLeavesIsNotMissed) {
  start_with_open_stores();
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
}  // namespace isosplat::server::test
