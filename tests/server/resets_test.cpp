// Clients that reset their connection at any stage: descriptors, connections and the memory of
// bodies are released. (tls_test.cpp tests the stages of TLS.)

#include <gtest/gtest.h>

#include <functional>

#include "tests/server/faulty_disk.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

class Resets : public ServerTest {
 protected:
  Resets() {
    write_file(folder.path() / "large.isosplat", large.file);
    write_file(folder.path() / "slow.isosplat", alpha.file);
    options.limits.bytes_in_flight = 1 << 20;    // two bodies: the test fails if they stay
    options.limits.connections_per_address = 3;  // the same for connections
    options.scan_interval = std::chrono::hours(1);
  }
  ~Resets() override { gate().open(); }

  static std::string request_for(const std::string& target) {
    return "GET " + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  }
  std::string large_file() const { return "/v1/volumes/large/" + large.content + "/file"; }
  std::string slow_file() const { return "/v1/volumes/slow/" + alpha.content + "/file"; }

  /// Whether the server has ended all other connections, and no longer counts them.
  bool has_released(size_t descriptors) const {
    return open_descriptors() <= descriptors &&
           get(port(), "/metrics").body.find("\nisosplat_connections_open 1\n") !=
               std::string::npos;
  }

  const KnownStore large = make_store(3, {128, 128, 128}, 2'000'000);  // more than sockets take
};

TEST_F(Resets, AtEveryStageReleaseEverything) {
  start();
  for (const std::string name : {"large", "slow", "alpha"}) {
    ASSERT_EQ(get(port(), "/v1/volumes/" + name).status, 200) << "opens the store";
  }
  ASSERT_TRUE(eventually([&] { return has_released(SIZE_MAX); }));
  const size_t before = open_descriptors();
  const auto send_and_reset = [&](const std::string& bytes) {
    Client client(port());
    EXPECT_TRUE(client.send(bytes));
    client.reset();
  };
  const std::vector<std::pair<const char*, std::function<void()>>> stages = {
      {"before the request line", [&] { send_and_reset(""); }},
      {"within the request line", [&] { send_and_reset("GET /v1/volu"); }},
      {"within the header", [&] { send_and_reset("GET /healthz HTTP/1.1\r\nHost: loc"); }},
      {"behind the request", [&] { send_and_reset(request_for(large_file())); }},
      {"while the disk is read",
       [&] {
         gate().close();
         Client client(port());
         EXPECT_TRUE(client.send(request_for(slow_file())));
         gate().await(1);
         client.reset();
         gate().open();
       }},
      {"within the body",
       [&] {
         Client client(port());
         client.set_receive_buffer(64 * 1024);
         EXPECT_TRUE(client.send(request_for(large_file())));
         EXPECT_EQ(client.read(200'000).size(), 200'000u);
         client.reset();
       }},
      {"within the body, with another request behind it",
       [&] {
         Client client(port());
         client.set_receive_buffer(64 * 1024);
         EXPECT_TRUE(client.send(request_for(large_file()) + request_for(content("file"))));
         EXPECT_EQ(client.read(100).size(), 100u);
         client.reset();
       }},
      {"between requests",
       [&] {
         Client client(port());
         EXPECT_EQ(client.request("GET", content("header")).status, 200);
         client.reset();
       }},
      {"within the next request",
       [&] {
         Client client(port());
         EXPECT_EQ(client.request("GET", content("header")).status, 200);
         EXPECT_TRUE(client.send("GET /v1"));
         client.reset();
       }},
      {"after a refusal", [&] {
         Client client(port());
         EXPECT_TRUE(client.send("nonsense\r\n\r\n"));
         EXPECT_EQ(client.receive().status, 400);
         client.reset();
       }}};
  for (const auto& [stage, reset_there] : stages) {
    for (int i = 0; i < 3; ++i) {
      reset_there();
      ASSERT_TRUE(eventually([&] { return has_released(before); })) << stage;
    }
    const Answer answer = get(port(), content("file"));
    EXPECT_EQ(answer.status, 200) << stage << answer.body;
    EXPECT_TRUE(answer.body == text_of(alpha.file)) << stage;
    ASSERT_TRUE(eventually([&] { return has_released(before); })) << stage;
  }
}

}  // namespace
}  // namespace isosplat::server::test
