// Invalid requests, and clients that are slow.

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using std::chrono::milliseconds;

class HostileClients : public ServerTest {
 protected:
  /// Sends the bytes. The only response must have this status, and the connection must close after
  /// it. A request that is hidden in a body must get no response.
  void expect_refused(const std::string& bytes, int status) {
    Client client(port());
    client.send(bytes);
    const Answer answer = client.receive();
    EXPECT_EQ(answer.status, status) << bytes.substr(0, 200);
    EXPECT_EQ(answer.header("connection"), "close") << bytes.substr(0, 200);
    EXPECT_EQ(client.receive().status, 0) << "a second answer to " << bytes.substr(0, 200);
  }

  static std::string get_with(const std::string& headers, const std::string& body = "") {
    return "GET /healthz HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n" + body;
  }
};

TEST_F(HostileClients, BodiesAreRefusedAndTheConnectionCloses) {
  start();
  const std::string hidden = "GET /v1/volumes HTTP/1.1\r\nHost: localhost\r\n\r\n";
  const std::string length = std::to_string(hidden.size());
  for (const std::string& headers : {
           std::string("Transfer-Encoding: chunked\r\n"),
           std::string("Transfer-Encoding: identity\r\n"),
           std::string("Transfer-Encoding: chunked\r\nContent-Length: 0\r\n"),
           std::string("Content-Length: 0\r\nTransfer-Encoding: chunked\r\n"),
           std::string("Transfer-Encoding: xchunked\r\n"),
           std::string("Transfer-Encoding:\tchunked\r\n"),
           std::string("transfer-encoding: chunked, identity\r\n"),
           std::string("Transfer-Encoding:\r\n chunked\r\n"),
           std::string("Transfer-Encoding: \r\n"),
           "Content-Length: " + length + "\r\n",
           "Content-Length: 0\r\nContent-Length: " + length + "\r\n",
           "Content-Length: " + length + "\r\nContent-Length: 0\r\n",
           std::string("Content-Length: 0\r\nContent-Length: 0\r\n"),
           std::string("Content-Length: 00\r\n"),
           std::string("Content-Length: +0\r\n"),
           std::string("Content-Length: -1\r\n"),
           std::string("Content-Length: 0x0\r\n"),
           std::string("Content-Length: 0, 0\r\n"),
           std::string("Content-Length: \r\n"),
           std::string("Content-Length: 18446744073709551616\r\n"),
           std::string("Content-Length : 5\r\n"),
           std::string("Transfer-Encoding : chunked\r\n"),
       }) {
    expect_refused(get_with(headers, hidden), 400);
    expect_refused("POST /healthz HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n" + hidden,
                   400);
  }
  Client client(port());
  EXPECT_EQ(client.request("GET", "/healthz", "Content-Length: 0\r\n").status, 200);
  EXPECT_EQ(client.request("GET", "/healthz").status, 200) << "no body was announced";
}

TEST_F(HostileClients, MalformedRequestsAreRefused) {
  start();
  for (const char* bytes : {
           "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03 tls hello\r\n\r\n",
           "GET\r\n\r\n",
           "GET /\r\n\r\n",
           "GET / HTTP/1.1 x\r\n\r\n",
           "GET  / HTTP/1.1\r\n\r\n",
           "GET / HTTTP/1.1\r\n\r\n",
           "G@T / HTTP/1.1\r\n\r\n",
           " GET / HTTP/1.1\r\n\r\n",
           "GET / HTTP/1.1\r\nHost x\r\n\r\n",
           "GET / HTTP/1.1\r\n: x\r\n\r\n",
           "GET / HTTP/1.1\r\nHo st: x\r\n\r\n",
           "GET / HTTP/1.1\r\nHost: a\x01b\r\n\r\n",
           "GET / HTTP/1.1\r\nHost: a\r\nX: a\rb\r\n\r\n",
           "GET /\x01 HTTP/1.1\r\nHost: a\r\n\r\n",
           "GET / HTTP/1.1\nHost: a\n\n",
           "GET / HTTP/1.1\r\nHost: a\nX: y\r\n\r\n",
           // a field on several lines (RFC 9112, 5.2)
           "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: a\r\n b\r\n\r\n",
           "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: a\r\n\tb\r\n\r\n",
           "GET /healthz HTTP/1.1\r\nHost:\r\n localhost\r\n\r\n",
           "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: a\r\n \r\n\r\n",
           "GET / HTTP/1.1\r\nHost: a\r\n\n",
           "\r\r\nGET / HTTP/1.1\r\nHost: a\r\n\r\n",
           "GET / HTTP/1.1\r\n\r\n",
           "GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
           "GET / HTTP/1.1\r\nHost: a\r\nHost: a\r\n\r\n",
       }) {
    expect_refused(bytes, 400);
  }
  for (const char* bytes :
       {"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", "GET / HTTP/0.9\r\n\r\n",
        "GET / HTTP/3.0\r\nHost: a\r\n\r\n", "GET / HTTP/1.2\r\nHost: a\r\n\r\n"}) {
    expect_refused(bytes, 505);
  }
}

TEST_F(HostileClients, RequestTextIsNotCopiedIntoResponseHeaders) {
  start();
  for (const char* target : {"/%0d%0aX-Evil:1", "/v1/volumes/%0aX-Evil:1", "/v1/volumes/x%20y",
                             "/evil", "/v1/volumes/alpha/evil/header"}) {
    const Answer answer = get(port(), target, "Origin: evil\r\nX-Evil: evil\r\n");
    for (const auto& [name, value] : answer.headers) {
      EXPECT_EQ(name.find("evil"), std::string::npos);
      EXPECT_EQ(value.find("evil"), std::string::npos) << name << ": " << value;
    }
  }
}

TEST_F(HostileClients, LongTargetsAndHeaders) {
  start();
  Client client(port());
  EXPECT_EQ(client.request("GET", "/" + std::string(8 * 1024 - 1, 'a')).status, 404);
  EXPECT_EQ(client.request("GET", "/" + std::string(8 * 1024, 'a')).status, 414);
  EXPECT_EQ(client.request("GET", "/healthz").status, 200) << "the connection stays";
  expect_refused("GET /" + std::string(40'000, 'a') + " HTTP/1.1\r\nHost: a\r\n\r\n", 414);
  expect_refused(get_with("X: " + std::string(17'000, 'a') + "\r\n"), 431);
  expect_refused(get_with("X: " + std::string(400'000, 'a') + "\r\n"), 431);
  std::string many;
  for (int i = 0; i < 4000; ++i) many += "A: b\r\n";
  expect_refused(get_with(many), 431);
  EXPECT_EQ(get(port(), "/healthz", "X: " + std::string(15'000, 'a') + "\r\n").status, 200);
}

TEST_F(HostileClients, PipelinedRequestsAreAnsweredInOrder) {
  start();
  Client client(port());
  std::string requests;
  for (size_t i = 0; i < 50; ++i) {
    requests += "GET " + content("chunks/" + place_of(alpha.chunks[i])) +
                " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  }
  client.send(requests);
  for (size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(client.receive().body, text_of(alpha.chunks[i].bytes)) << i;
  }
}

TEST_F(HostileClients, RequestsInSmallPieces) {
  start();
  Client client(port());
  for (const char c : get_with("")) {
    client.send(std::string(1, c));
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  EXPECT_EQ(client.receive().status, 200);
}

TEST_F(HostileClients, EmptyLinesBeforeARequestAreIgnored) {
  start();
  Client client(port());
  client.send("\r\n\r\n" + get_with("") + "\r\n" + get_with(""));
  EXPECT_EQ(client.receive().status, 200);
  EXPECT_EQ(client.receive().status, 200);
  client.send("\r");
  std::this_thread::sleep_for(milliseconds(20));
  client.send("\n" + get_with(""));
  EXPECT_EQ(client.receive().status, 200);
}

TEST_F(HostileClients, KeepAliveAndClose) {
  start();
  Client old(port());
  old.send("GET /healthz HTTP/1.0\r\n\r\n");
  EXPECT_EQ(old.receive().header("connection"), "close");
  EXPECT_TRUE(old.is_closed());
  Client old_kept(port());
  old_kept.send("GET /healthz HTTP/1.0\r\nConnection: keep-alive\r\n\r\n");
  EXPECT_EQ(old_kept.receive().header("connection"), "keep-alive");
  EXPECT_EQ(old_kept.request("GET", "/healthz").status, 200);
  Client closing(port());
  EXPECT_EQ(closing.request("GET", "/healthz", "Connection: close\r\n").header("connection"),
            "close");
  EXPECT_TRUE(closing.is_closed());
}

TEST_F(HostileClients, AnyOfSeveralConnectionFieldsCloses) {
  start();
  for (const char* fields : {"Connection: keep-alive\r\nConnection: close\r\n",
                             "Connection: close\r\nConnection: keep-alive\r\n",
                             "Connection: x\r\nAccept: */*\r\nConnection: y, Close\r\n"}) {
    Client client(port());
    const Answer answer = client.request("GET", "/healthz", fields);
    EXPECT_EQ(answer.status, 200) << fields;
    EXPECT_EQ(answer.header("connection"), "close") << fields;
    EXPECT_TRUE(client.is_closed()) << fields;
  }
}

TEST_F(HostileClients, HalfARequestIsDisconnected) {
  options.limits.request_time = milliseconds(200);
  start();
  Client client(port());
  client.send("GET /healthz HT");
  EXPECT_TRUE(client.is_closed());
  // The limit is for the whole header: single bytes do not prolong it.
  Client slow(port());
  slow.send("GET /healthz HTTP/1.1\r\n");
  bool closed = false;
  for (int line = 0; line < 1000 && !closed; ++line) {  // far beyond request_time
    slow.send("X: y\r\n");
    closed = slow.is_closed_within(milliseconds(20));
  }
  EXPECT_TRUE(closed);
  EXPECT_EQ(get(port(), "/healthz").status, 200);
}

TEST_F(HostileClients, IdleConnectionsAreDisconnected) {
  options.limits.idle_time = milliseconds(700);
  start();
  Client silent(port());
  EXPECT_TRUE(silent.is_closed());
  // The same after a response. (If the test itself is delayed for idle_time, the connection is
  // closed.)
  int status = 0;
  for (int attempt = 0; attempt < 100 && status == 0; ++attempt) {
    Client client(port());
    status = client.request("GET", "/healthz").status;
    EXPECT_TRUE(client.is_closed());
  }
  EXPECT_EQ(status, 200);
}

TEST_F(HostileClients, AClientThatDoesNotReadIsDisconnected) {
  const KnownStore large = make_store(3, {128, 128, 128}, 2'000'000);
  write_file(folder.path() / "large.isosplat", large.file);
  options.limits.write_time = milliseconds(500);
  options.limits.connections = 1;
  start();
  Client client(port());
  client.set_receive_buffer(64 * 1024);
  client.send("GET /v1/volumes/large/" + large.content +
              "/file HTTP/1.1\r\nHost: localhost\r\n\r\n");
  size_t received = client.read(12).size();
  // Until this client is closed, it has the only connection.
  EXPECT_TRUE(eventually([&] { return get(port(), "/healthz").status == 200; }));
  for (std::string part; !(part = client.read(1 << 20)).empty();) received += part.size();
  EXPECT_LT(received, large.file.size());
}

TEST_F(HostileClients, AClientThatReadsSlowlyGetsEverything) {
  const KnownStore large = make_store(3, {128, 128, 128}, 2'000'000);
  write_file(folder.path() / "large.isosplat", large.file);
  options.limits.write_time = milliseconds(1000);
  start();
  // The whole body takes longer than write_time, but each piece does not. (If the test itself was
  // delayed for that long, it is repeated.)
  size_t most = 0;
  for (int attempt = 0; attempt < 20 && most < 2'000'000; ++attempt) {
    Client patient(port());
    patient.set_receive_buffer(256 * 1024);
    patient.send("GET /v1/volumes/large/" + large.content +
                 "/file HTTP/1.1\r\nHost: localhost\r\nRange: bytes=0-1999999\r\n\r\n");
    size_t all = 0;
    for (std::string part; !(part = patient.read(100'000)).empty() && all < 2'000'000;) {
      all += part.size();
      std::this_thread::sleep_for(milliseconds(80));
    }
    most = std::max(most, all);
  }
  EXPECT_GE(most, 2'000'000u);
}

TEST_F(HostileClients, BusyConnectionsAreLimited) {
  const KnownStore large = make_store(3, {128, 128, 128}, 8'000'000);
  write_file(folder.path() / "large.isosplat", large.file);
  options.limits.connections = 4;
  options.is_public = true;  // so that other pages can read the reason, too
  start();
  std::vector<Client> clients;
  for (int i = 0; i < 4; ++i) {
    clients.emplace_back(port());
    clients.back().set_receive_buffer(64 * 1024);
    clients.back().send("GET /v1/volumes/large/" + large.content +
                        "/file HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(clients.back().read(12), "HTTP/1.1 200");
  }
  Client refused(port());
  const Answer answer = refused.receive();
  EXPECT_EQ(answer.status, 503);
  EXPECT_EQ(answer.header("retry-after"), "1");
  EXPECT_EQ(answer.header("access-control-allow-origin"), "*");
  EXPECT_TRUE(refused.is_closed());
  clients.pop_back();
  EXPECT_TRUE(eventually([&] { return get(port(), "/healthz").status == 200; }));
}

TEST_F(HostileClients, IdleConnectionsMakeRoom) {
  options.limits.connections = 8;
  start();
  std::vector<Client> idle;
  for (int i = 0; i < 8; ++i) {
    idle.emplace_back(port());
    // Some have sent no request, some a part of one, and some have received a response.
    if (i % 4 == 1) idle.back().send("GET /healthz HT");
    if (i % 4 < 2) continue;
    EXPECT_EQ(idle.back().request("GET", "/healthz").status, 200);
  }
  // Each new connection is served at once; the one that has waited longest is closed for it.
  std::vector<Client> honest;
  for (int i = 0; i < 4; ++i) {
    honest.emplace_back(port());
    EXPECT_EQ(honest.back().request("GET", "/healthz").status, 200) << i;
  }
  // The server closes four of the eight. Which ones depends on when it accepted them.
  size_t closed = 0;
  EXPECT_TRUE(eventually([&] {
    closed = 0;
    for (Client& client : idle) closed += client.is_closed_within(milliseconds(20)) ? 1 : 0;
    return closed >= 4;
  }));
  EXPECT_EQ(closed, 4u);
  for (Client& client : honest) EXPECT_EQ(client.request("GET", "/healthz").status, 200);
}

TEST_F(HostileClients, ABusyConnectionIsNotClosedForAnother) {
  const KnownStore large = make_store(3, {128, 128, 128}, 2'000'000);
  write_file(folder.path() / "large.isosplat", large.file);
  options.limits.connections = 2;
  start();
  Client busy(port());
  busy.set_receive_buffer(64 * 1024);
  busy.send("GET /v1/volumes/large/" + large.content + "/file HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(busy.read(12), "HTTP/1.1 200");
  // While the previous connection is ending, the server is full, and no connection waits: 503.
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(eventually([&] { return get(port(), "/healthz").status == 200; })) << i;
  }
  size_t rest = 0;
  // Bytes of the header count here instead of the last bytes of the body.
  while (rest < large.file.size()) {
    const std::string part = busy.read(std::min<size_t>(1 << 16, large.file.size() - rest));
    if (part.empty()) break;
    rest += part.size();
  }
  EXPECT_GE(rest, large.file.size());
}

TEST_F(HostileClients, ConnectionsOfOneAddressAreLimited) {
  options.limits.connections_per_address = 2;
  start();
  Client first(port());
  Client second(port());
  EXPECT_EQ(first.request("GET", "/healthz").status, 200);
  EXPECT_EQ(second.request("GET", "/healthz").status, 200);
  Client third(port());
  const Answer answer = third.request("GET", "/healthz");
  EXPECT_EQ(answer.status, 429);
  EXPECT_EQ(answer.header("retry-after"), "1");
}

TEST_F(HostileClients, ManyConnections) {
  options.limits.connections = 600;
  options.limits.connections_per_address = 0;
  start();
  std::vector<Client> clients;
  for (int i = 0; i < 400; ++i) clients.emplace_back(port());
  for (Client& client : clients) client.send(get_with(""));
  for (Client& client : clients) EXPECT_EQ(client.receive().status, 200);
  for (Client& client : clients) EXPECT_EQ(client.request("GET", "/healthz").status, 200);
}

TEST_F(HostileClients, ConnectionsThatEndEarlyAreReleased) {
  options.limits.connections = 8;
  const KnownStore large = make_store(3, {128, 128, 128}, 1'000'000);
  write_file(folder.path() / "large.isosplat", large.file);
  start();
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(eventually([&] {
      Client client(port());
      client.send("GET /v1/volumes/large/" + large.content +
                  "/file HTTP/1.1\r\nHost: localhost\r\n\r\n");
      return client.read(12) == "HTTP/1.1 200";
    }));
  }
  EXPECT_TRUE(eventually([&] { return get(port(), "/healthz").status == 200; }));
}

}  // namespace
}  // namespace isosplat::server::test
