// Limits of rates and of memory.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "server/limits/byte_budget.h"
#include "server/limits/rate_limit.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Clock = RateLimit::Clock;
using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(RateLimits, ABucketOfRequestsEmptiesAndFills) {
  RateLimit limit({.requests = 2, .bytes = 0});
  const Clock::time_point start{};
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(limit.take_request("a", start)) << i;
  EXPECT_EQ(limit.take_request("a", start), 1u);
  EXPECT_FALSE(limit.take_request("b", start));
  EXPECT_FALSE(limit.take_request("a", start + milliseconds(500)));
  EXPECT_EQ(limit.take_request("a", start + milliseconds(999)), 1u);
  // However long it waits, a client has at most a full bucket.
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(limit.take_request("a", start + seconds(1000))) << i;
  EXPECT_TRUE(limit.take_request("a", start + seconds(1000)));
}

TEST(RateLimits, AResponseMayExceedTheBucket) {
  RateLimit limit({.requests = 0, .bytes = 1000});
  const Clock::time_point start{};
  EXPECT_FALSE(limit.take_request("a", start));
  limit.take_bytes("a", 15'000, start);  // of the 10,000 in the bucket
  EXPECT_EQ(limit.take_request("a", start), 5u);
  EXPECT_EQ(limit.take_request("a", start + seconds(3)), 2u);
  EXPECT_FALSE(limit.take_request("a", start + seconds(5)));
  limit.take_bytes("a", UINT64_MAX, start + seconds(5));
  EXPECT_EQ(limit.take_request("a", start + seconds(5)), 3600u);
}

TEST(RateLimits, ForgetTheOldestOfManyAddresses) {
  RateLimit limit({.requests = 0.1, .bytes = 0});
  const Clock::time_point start{};
  EXPECT_FALSE(limit.take_request("first", start));
  EXPECT_TRUE(limit.take_request("first", start));
  EXPECT_FALSE(limit.take_request("kept", start));
  for (size_t i = 0; i + 2 < RateLimit::kMaxAddresses; ++i) {
    limit.take_request(std::to_string(i), start);
  }
  EXPECT_TRUE(limit.take_request("kept", start));
  for (int i = 0; i < 10; ++i) limit.take_request("another " + std::to_string(i), start);
  EXPECT_EQ(limit.addresses(), RateLimit::kMaxAddresses);
  EXPECT_TRUE(limit.take_request("kept", start));
  EXPECT_FALSE(limit.take_request("first", start));
}

TEST(ByteBudgets, AreSharedAndReleased) {
  ByteBudget budget(100);
  ByteBudget::Share large;
  EXPECT_TRUE(large.take(budget, 1000, "one")) << "alone, a body may be larger than the budget";
  {
    ByteBudget::Share other;
    EXPECT_FALSE(other.take(budget, 1, "another"));
  }
  EXPECT_EQ(budget.used(), 1000u);
  {
    ByteBudget next(100);
    ByteBudget::Share a, b, c;
    EXPECT_TRUE(a.take(next, 60, "one"));
    EXPECT_TRUE(b.take(next, 40, "one"));
    EXPECT_FALSE(c.take(next, 1, "one"));
    EXPECT_TRUE(c.take(next, 0, "one")) << "no body";
    EXPECT_EQ(next.used(), 100u);
  }
}

TEST(ByteBudgets, OneAddressGetsAPart) {
  ByteBudget budget(100, 25);
  ByteBudget::Share a, c, d, e;
  {
    ByteBudget::Share b;
    EXPECT_TRUE(a.take(budget, 10, "one"));
    EXPECT_TRUE(b.take(budget, 15, "one"));
    EXPECT_FALSE(c.take(budget, 1, "one"));
    EXPECT_TRUE(d.take(budget, 70, "another")) << "alone, a body may be larger than its part";
    EXPECT_FALSE(e.take(budget, 1, "another"));
  }
  EXPECT_EQ(budget.used(), 80u);
  EXPECT_TRUE(c.take(budget, 15, "one")) << "the memory of sent bytes is released";
  EXPECT_FALSE(e.take(budget, 6, "a third")) << "the budget of all";
  EXPECT_TRUE(e.take(budget, 5, "a third"));
}

class Limits : public ServerTest {};

TEST_F(Limits, RequestsAboveTheRateAreRefusedAndTheConnectionStays) {
  options.limits.requests_per_second = 0.01;  // one request, then one every 100 s
  start();
  Client client(port());
  EXPECT_EQ(client.request("GET", "/healthz").status, 200);
  const Answer answer = client.request("GET", "/healthz");
  EXPECT_EQ(answer.status, 429);
  EXPECT_NE(answer.body.find("too_many_requests"), std::string::npos);
  const int wait = std::stoi(answer.header("retry-after"));
  EXPECT_GE(wait, 1);
  EXPECT_LE(wait, 100);
  EXPECT_EQ(answer.header("x-content-type-options"), "nosniff");
  EXPECT_EQ(answer.header("cross-origin-resource-policy"), "same-origin");
  EXPECT_EQ(client.request("GET", "/healthz").status, 429);
  EXPECT_EQ(get(port(), "/healthz").status, 429) << "a new connection of the same address";
}

TEST_F(Limits, EachTokenHasASeparateRate) {
  write_file(folder.path() / "tokens",
             "0123456789abcdef-one name=one *\n0123456789abcdef-two *\nanyone alpha\n");
  options.token_file = folder.path() / "tokens";
  options.tokens = {"0123456789abcdef-own"};
  options.limits.requests_per_second = 0.01;  // one request, then one every 100 s
  start();
  const auto status = [&](const char* from, const std::string& token) {
    const std::string field = token.empty() ? "" : "Authorization: Bearer " + token + "\r\n";
    return Client(port(), from).request("GET", "/v1/volumes/alpha", field).status;
  };
  const std::string one = "0123456789abcdef-one", two = "0123456789abcdef-two";
  EXPECT_EQ(status("127.0.0.2", one), 200);
  EXPECT_EQ(status("127.0.0.2", one), 429);
  EXPECT_EQ(status("127.0.0.3", one), 429) << "from any address";
  EXPECT_EQ(status("127.0.0.2", two), 200);
  EXPECT_EQ(status("127.0.0.2", two), 429) << "also without a name";
  EXPECT_EQ(status("127.0.0.2", ""), 200) << "the first request of the address";
  EXPECT_EQ(status("127.0.0.2", ""), 429);
  EXPECT_EQ(status("127.0.0.2", "0123456789abcdef-bad"), 429) << "no token";
  EXPECT_EQ(status("127.0.0.2", "0123456789abcdef-own"), 429)
      << "this token counts for the address";
  EXPECT_EQ(status("127.0.0.3", "0123456789abcdef-own"), 200);
  // Requests that are refused before the client is identified count for the address as well.
  Client foreign(port(), "127.0.0.4");
  foreign.send("GET /v1/volumes HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  EXPECT_EQ(foreign.receive().status, 403);
  foreign.send("GET /v1/volumes HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  const Answer refused = foreign.receive();
  EXPECT_EQ(refused.status, 429);
  EXPECT_EQ(refused.header("x-content-type-options"), "nosniff");
}

TEST_F(Limits, BytesAboveTheRateAreRefusedAfterTheResponse) {
  options.limits.bytes_per_second = 10;
  start();
  Client client(port());
  client.send("HEAD " + content("file") + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(client.receive(true).status, 200);
  const Answer file = client.request("GET", content("file"));
  EXPECT_EQ(file.status, 200);
  EXPECT_EQ(file.body, text_of(alpha.file));
  EXPECT_EQ(client.request("GET", content("header")).status, 429);
}

TEST_F(Limits, BodiesAboveTheMemoryAreRefused) {
  const KnownStore large = make_store(3, {128, 128, 128}, 2'000'000);
  write_file(folder.path() / "large.isosplat", large.file);
  options.limits.bytes_in_flight = 1;
  start();
  // If a client stops reading, its response keeps memory until the connection ends.
  auto slow = std::make_unique<Client>(port());
  slow->set_receive_buffer(64 * 1024);
  slow->send("GET /v1/volumes/large/" + large.content +
             "/file HTTP/1.1\r\nHost: localhost\r\n\r\n");
  slow->read(12);
  Client other(port());
  const Answer answer = other.request("GET", content("file"));
  EXPECT_EQ(answer.status, 503);
  EXPECT_NE(answer.body.find("busy"), std::string::npos);
  EXPECT_EQ(answer.header("retry-after"), "1");
  slow.reset();
  EXPECT_TRUE(eventually([&] { return other.request("GET", content("file")).status == 200; }));
}

/// Bytes that the server has written to the clients of a port, and that they have not acknowledged.
uint64_t unacknowledged_bytes(uint16_t port) {
  std::ifstream table("/proc/net/tcp");
  std::string line;
  uint64_t bytes = 0;
  while (std::getline(table, line)) {
    // "0: 0100007F:1F90 0100007F:C001 01 0000FFFF:00000000 …": local, remote, state, queues
    std::istringstream fields(line);
    std::string slot, local, remote, state, queues;
    fields >> slot >> local >> remote >> state >> queues;
    if (state == "01" && local.ends_with(fmt::format(":{:04X}", port))) {
      bytes += std::stoull(queues.substr(0, 8), nullptr, 16);
    }
  }
  return bytes;
}

TEST_F(Limits, TheSystemHoldsLittleForASlowClient) {
  const KnownStore large = make_store(3, {256, 128, 128}, 2'000'000);
  ASSERT_GT(large.file.size(), 8'000'000u);
  write_file(folder.path() / "large.isosplat", large.file);
  start();
  Client slow(port());
  slow.set_receive_buffer(64 * 1024);
  slow.send("GET /v1/volumes/large/" + large.content + "/file HTTP/1.1\r\nHost: localhost\r\n\r\n");
  slow.read(12);
  // The server writes until the system's buffers are full.
  uint64_t held = 0;
  int unchanged = 0;
  EXPECT_TRUE(eventually([&] {
    const uint64_t now = unacknowledged_bytes(port());
    unchanged = now == held && now > 0 ? unchanged + 1 : 0;
    held = now;
    return unchanged == 50;
  }));
  EXPECT_LT(held, 1'000'000u);
}

}  // namespace
}  // namespace isosplat::server::test
