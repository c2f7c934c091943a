// The client's address behind a proxy: limits, rates and logs use the address that a trusted proxy
// states, and ignore addresses that others state.

#include <gtest/gtest.h>

#include <mutex>

#include "server/access/ip_address.h"
#include "server/access/proxy_header.h"
#include "server/access/trusted_proxies.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using namespace std::string_literals;

IpAddress address(std::string_view text) {
  const auto parsed = IpAddress::parse(text);
  EXPECT_TRUE(parsed) << text;
  return parsed.value_or(IpAddress{});
}

TEST(IpAddresses, BothFormsOfAnAddressAreOneClient) {
  EXPECT_EQ(address("::ffff:192.0.2.7"), address("192.0.2.7"));
  EXPECT_EQ(address("192.0.2.7").client_key(), "192.0.2.7");
  EXPECT_EQ(address("2001:db8:1:2:3:4:5:6").client_key(), "2001:db8:1:2::");
  EXPECT_EQ(address("::1").client_key(), "::1");
  EXPECT_TRUE(address("127.8.8.8").is_loopback());
  for (const std::string& text :
       {""s, "1.2.3"s, "01.2.3.4"s, "1.2.3.4 "s, "1.2.3.4\0"s, "::1%lo"s, "[::1]"s, "localhost"s,
        "::ffff:1.2.3.4.5"s, std::string(1000, '1')}) {
    EXPECT_FALSE(IpAddress::parse(text)) << text;
  }
}

TEST(IpAddresses, RangesContainTheAddressesWithTheirPrefix) {
  const auto contains = [](std::string_view range, std::string_view of) {
    const Result<AddressRange> parsed = AddressRange::parse(range);
    EXPECT_TRUE(parsed) << range;
    return parsed && parsed->contains(address(of));
  };
  EXPECT_TRUE(contains("10.0.0.0/8", "10.255.0.1"));
  EXPECT_FALSE(contains("10.0.0.0/8", "11.0.0.0"));
  EXPECT_TRUE(contains("10.0.0.0/8", "::ffff:10.1.2.3"));
  EXPECT_TRUE(contains("192.0.2.4/30", "192.0.2.7"));
  EXPECT_FALSE(contains("192.0.2.4/30", "192.0.2.8"));
  EXPECT_TRUE(contains("192.0.2.4", "192.0.2.4"));
  EXPECT_FALSE(contains("0.0.0.0/0", "2001:db8::1"));
  EXPECT_TRUE(contains("::/0", "192.0.2.4"));
  EXPECT_TRUE(contains("2001:db8:8000::/33", "2001:db8:ffff::"));
  EXPECT_FALSE(contains("2001:db8:8000::/33", "2001:db8:7fff::"));
  for (const char* text : {"", "/8", "10.0.0.0/", "10.0.0.0/33", "10.0.0.0/-1", "10.0.0.0/8x",
                           "::/129", "10.0.0.1/8", "any", "10.0.0.0/8/8"}) {
    EXPECT_FALSE(AddressRange::parse(text)) << text;
  }
  EXPECT_NE(AddressRange::parse("10.0.0.1/8").error().message.find("expected 10.0.0.0/8"),
            std::string::npos);
}

std::string client_of(ClientField field, std::string_view peer, std::string_view addresses,
                      std::string_view scheme = {}) {
  const auto proxies = TrustedProxies::parse({"10.0.0.0/8", "fd00::/8"},
                                             {.client = field, .user = "", .groups = ""});
  const TrustedProxies::Client client = proxies->client_of(address(peer), addresses, scheme);
  return client.address.text() + (client.has_tls ? " tls" : "");
}

TEST(TrustedProxy, TakesTheRightmostAddressThatIsNotTrusted) {
  const auto field = ClientField::x_forwarded_for;
  EXPECT_EQ(client_of(field, "10.0.0.1", "192.0.2.7"), "192.0.2.7");
  // The client invented the first item.
  EXPECT_EQ(client_of(field, "10.0.0.1", "1.1.1.1, 192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(client_of(field, "10.0.0.1", "1.1.1.1,192.0.2.7 , 10.0.0.2,fd00::1"), "192.0.2.7");
  EXPECT_EQ(client_of(field, "10.0.0.1", "10.0.0.3, 10.0.0.2"), "10.0.0.3");
  EXPECT_EQ(client_of(field, "10.0.0.1", ""), "10.0.0.1");
  EXPECT_EQ(client_of(field, "192.0.2.9", "1.1.1.1"), "192.0.2.9") << "not a proxy";
  // With ports, and in brackets.
  EXPECT_EQ(client_of(field, "10.0.0.1", "192.0.2.7:1234"), "192.0.2.7");
  EXPECT_EQ(client_of(field, "10.0.0.1", "[2001:db8::7]:1234"), "2001:db8::7");
  EXPECT_EQ(client_of(field, "10.0.0.1", "2001:db8::7"), "2001:db8::7");
  // An item that is not an address ends the search: the proxy that added it counts as the client.
  for (const char* item : {"unknown", "_hidden", "1.2.3.4.5", "1.2.3.4:", "1.2.3.4:x", "[::1",
                           "[1.2.3.4]", "[::1]x", "\"", "1.1.1.1, ,"}) {
    EXPECT_EQ(client_of(field, "10.0.0.1", item), "10.0.0.1") << item;
    EXPECT_EQ(client_of(field, "10.0.0.1", item + ", 10.0.0.2"s), "10.0.0.2") << item;
  }
  EXPECT_EQ(client_of(field, "10.0.0.1", "192.0.2.7", "https"), "192.0.2.7 tls");
  EXPECT_EQ(client_of(field, "10.0.0.1", "192.0.2.7", "https, http"), "192.0.2.7");
  EXPECT_EQ(client_of(field, "192.0.2.9", "192.0.2.7", "https"), "192.0.2.9");
}

TEST(TrustedProxy, ReadsForwardedFromTheRight) {
  const auto field = ClientField::forwarded;
  EXPECT_EQ(client_of(field, "10.0.0.1", "for=192.0.2.7;proto=https;by=10.0.0.1"), "192.0.2.7 tls");
  EXPECT_EQ(client_of(field, "10.0.0.1", "For=\"[2001:db8::7]:4711\"; Proto=http"), "2001:db8::7");
  EXPECT_EQ(client_of(field, "10.0.0.1", "for=1.1.1.1, for=192.0.2.7, for=10.0.0.2"), "192.0.2.7");
  // A quote that the client does not close does not extend into the item of the proxy.
  EXPECT_EQ(client_of(field, "10.0.0.1", "for=\"evil, for=192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(client_of(field, "10.0.0.1", "for=1.1.1.1;x=\", for=192.0.2.7;proto=https"),
            "192.0.2.7 tls");
  for (const char* item : {"for=unknown", "for=_x", "for=", "for", "proto=https", "1.1.1.1",
                           "for=1.1.1.1;for=2.2.2.2", "for=\"1.1.1.1", "for=\"1.1.1.1\\\""}) {
    EXPECT_EQ(client_of(field, "10.0.0.1", item), "10.0.0.1") << item;
  }
  EXPECT_EQ(client_of(field, "10.0.0.1", "192.0.2.7", "https"), "10.0.0.1") << "the other field";
}

/// A header of version 2.
std::string version_2(char command, char family, std::string_view content) {
  std::string header("\r\n\r\n\0\r\nQUIT\n", 12);
  header += {command, family, static_cast<char>(content.size() >> 8),
             static_cast<char>(content.size() & 255)};
  return header + std::string(content);
}

const std::string kV4 = "\xc0\x00\x02\x07\x0a\x00\x00\x01\x12\x34\x01\xbb"s;

TEST(ProxyHeaders, BothVersionsNameTheClient) {
  const std::string v6 =
      address("2001:db8::7").bytes.data() != nullptr
          ? std::string(reinterpret_cast<const char*>(address("2001:db8::7").bytes.data()), 16) +
                std::string(16, '\1') + "\x12\x34\x01\xbb"
          : "";
  struct Case {
    std::string header, source;
    bool is_local = false;
  };
  for (const Case& each : std::initializer_list<Case>{
           {"PROXY TCP4 192.0.2.7 10.0.0.1 56324 443\r\n", "192.0.2.7"},
           {"PROXY TCP6 2001:db8::7 ::1 1 65535\r\n", "2001:db8::7"},
           {"PROXY UNKNOWN\r\n", ""},
           {"PROXY UNKNOWN anything at all\r\n", ""},
           {version_2(0x21, 0x11, kV4), "192.0.2.7"},
           {version_2(0x21, 0x11, kV4 + std::string(2000, 'x')), "192.0.2.7"},  // TLVs
           {version_2(0x21, 0x21, v6), "2001:db8::7"},
           {version_2(0x20, 0x00, ""), "", true},
           {version_2(0x20, 0x11, kV4), "", true},
           {version_2(0x21, 0x00, "x"), ""},
           {version_2(0x21, 0x31, std::string(216, 'x')), ""}}) {
    const ProxyHeader whole = parse_proxy_header(each.header + "GET / HTTP/1.1\r\n");
    EXPECT_EQ(whole.state, ProxyHeader::State::complete) << each.header;
    EXPECT_EQ(whole.bytes, each.header.size()) << each.header;
    EXPECT_EQ(whole.source ? whole.source->text() : "", each.source);
    EXPECT_EQ(whole.is_local, each.is_local);
    for (size_t bytes = 0; bytes < each.header.size(); ++bytes) {
      EXPECT_EQ(parse_proxy_header(std::string_view(each.header).substr(0, bytes)).state,
                ProxyHeader::State::partial)
          << bytes << " bytes of " << each.header;
    }
  }
}

const std::vector<std::string>& malformed_headers() {
  static const std::vector<std::string> headers = {
      "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "proxy TCP4 192.0.2.7 10.0.0.1 1 2\r\n",
      "PROXY TCP5 192.0.2.7 10.0.0.1 1 2\r\n",
      "PROXY TCP4 2001:db8::7 ::1 1 2\r\n",
      "PROXY TCP4 192.0.2.7 10.0.0.1 1\r\n",
      "PROXY TCP4 192.0.2.7 10.0.0.1 1 65536\r\n",
      "PROXY TCP4 192.0.2.7 10.0.0.1 01 2\r\n",
      "PROXY TCP4 192.0.2.7 10.0.0.1 1 2 3\r\n",
      "PROXY TCP4  192.0.2.7 10.0.0.1 1 2\r\n",
      "PROXY TCP4 192.0.2.7\n10.0.0.1 1 2\r\n",
      "PROXY TCP4 localhost 10.0.0.1 1 2\r\n",
      "PROXY " + std::string(200, 'x'),
      version_2(0x11, 0x11, kV4),
      version_2(0x22, 0x11, kV4),
      version_2(0x21, 0x41, kV4),
      version_2(0x21, 0x12, kV4),  // datagrams
      version_2(0x21, 0x11, kV4.substr(0, 11)),
      version_2(0x21, 0x21, kV4),
      version_2(0x21, 0x11, std::string(60'000, 'x')),
      "\r\n\r\nQUIT",
  };
  return headers;
}

TEST(ProxyHeaders, MalformedOnesAreRefused) {
  for (const std::string& header : malformed_headers()) {
    EXPECT_EQ(parse_proxy_header(header).state, ProxyHeader::State::malformed) << header;
  }
}

class BehindProxy : public ServerTest {
 protected:
  BehindProxy() {
    options.access_log = [this](std::string_view line) {
      const std::lock_guard lock(mutex);
      logged.emplace_back(line.substr(0, line.find(' ')));
    };
  }
  ~BehindProxy() override { server.reset(); }  // it logs until its end

  /// The address in the log of the latest response.
  std::string last_logged(size_t responses) {
    EXPECT_TRUE(eventually([&] {
      const std::lock_guard lock(mutex);
      return logged.size() >= responses;
    }));
    const std::lock_guard lock(mutex);
    return logged.back();
  }

  std::mutex mutex;
  std::vector<std::string> logged;
};

TEST_F(BehindProxy, LogsAndRatesAreThoseOfTheClient) {
  options.trusted_proxies = {"127.0.0.0/8"};
  options.limits.requests_per_second = 0.2;  // two at once
  start();
  Client proxy(port());
  const auto status = [&](const std::string& forwarded) {
    return proxy.request("GET", "/healthz", "X-Forwarded-For: " + forwarded + "\r\n").status;
  };
  EXPECT_EQ(status("192.0.2.7"), 200);
  EXPECT_EQ(last_logged(1), "192.0.2.7");
  EXPECT_EQ(status("192.0.2.7"), 200);
  EXPECT_EQ(status("192.0.2.7"), 429);
  EXPECT_EQ(status("6.6.6.6, 192.0.2.7"), 429) << "a forged address does not give another rate";
  EXPECT_EQ(status("2001:db8::7"), 200) << "another client of the same connection";
  EXPECT_EQ(last_logged(5), "2001:db8::");
  EXPECT_EQ(proxy
                .request("GET", "/healthz",
                         "X-Forwarded-For: 6.6.6.6\r\nX-Forwarded-For: "
                         "192.0.2.8, 127.0.0.2\r\n")
                .status,
            200);
  EXPECT_EQ(last_logged(6), "192.0.2.8") << "several fields are one list";
  EXPECT_EQ(proxy.request("GET", "/healthz", "Forwarded: for=192.0.2.9\r\n").status, 200);
  EXPECT_EQ(last_logged(7), "127.0.0.1") << "the proxy does not set this field";
}

TEST_F(BehindProxy, OthersCannotChooseTheirAddress) {
  options.trusted_proxies = {"10.0.0.0/8", "127.0.0.2"};
  start();
  EXPECT_EQ(get(port(), "/healthz", "X-Forwarded-For: 192.0.2.7\r\n").status, 200);
  EXPECT_EQ(last_logged(1), "127.0.0.1");
  EXPECT_EQ(get(port(), "/metrics", "X-Forwarded-For: 127.0.0.1\r\n").status, 403);
  Client client(port());
  client.send("PROXY TCP4 192.0.2.7 10.0.0.1 1 2\r\nGET /healthz HTTP/1.1\r\nHost: a\r\n\r\n");
  EXPECT_EQ(client.receive().status, 400);
}

TEST_F(BehindProxy, AClientCannotClaimToBeThisMachine) {
  options.trusted_proxies = {"127.0.0.1"};
  start();
  EXPECT_EQ(get(port(), "/metrics", "X-Forwarded-For: ::1\r\n").status, 403);
  EXPECT_EQ(get(port(), "/metrics").status, 200);
}

TEST_F(BehindProxy, ConnectionsOfAProxyAreNotThoseOfOneClient) {
  options.trusted_proxies = {"127.0.0.1"};
  options.limits.connections_per_address = 1;
  start();
  std::vector<Client> clients;
  for (int i = 0; i < 5; ++i) {
    clients.emplace_back(port());
    EXPECT_EQ(clients.back().request("GET", "/healthz", "X-Forwarded-For: 192.0.2.7\r\n").status,
              200);
  }
}

TEST_F(BehindProxy, CookiesAreForTlsIfTheClientHasIt) {
  options.trusted_proxies = {"127.0.0.1"};
  options.tokens = {"token-0123456789abcdef"};
  start();
  const std::string target = "/?token=token-0123456789abcdef";
  EXPECT_TRUE(get(port(), target, "X-Forwarded-For: 192.0.2.7\r\nX-Forwarded-Proto: https\r\n")
                  .header("set-cookie")
                  .ends_with("; Secure"));
  EXPECT_FALSE(get(port(), target, "X-Forwarded-For: 192.0.2.7\r\nX-Forwarded-Proto: http\r\n")
                   .header("set-cookie")
                   .ends_with("; Secure"));
}

class BehindBalancer : public BehindProxy {
 protected:
  BehindBalancer() {
    options.trusted_proxies = {"127.0.0.1"};
    options.proxy_fields.client = ClientField::proxy_protocol;
  }
  static std::string header_of(const std::string& client) {
    return "PROXY TCP4 " + client + " 10.0.0.1 56324 443\r\n";
  }
};

TEST_F(BehindBalancer, TheHeaderNamesTheClient) {
  start();
  Client client(port());
  client.send(header_of("192.0.2.7"));
  EXPECT_EQ(client.request("GET", "/healthz", "X-Forwarded-For: 6.6.6.6\r\n").status, 200);
  EXPECT_EQ(last_logged(1), "192.0.2.7");
  EXPECT_EQ(client.request("GET", "/metrics").status, 403);
  Client binary(port());
  // The header is sent byte by byte, and a request follows it.
  for (const char byte : version_2(0x21, 0x11, kV4)) binary.send({&byte, 1});
  EXPECT_EQ(binary.request("GET", "/healthz").status, 200);
  EXPECT_EQ(last_logged(3), "192.0.2.7");
  Client itself(port());
  itself.send(version_2(0x20, 0, "") + "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(itself.receive().status, 200) << "a health check of the balancer";
  Client unknown(port());
  unknown.send("PROXY UNKNOWN\r\nGET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(unknown.receive().status, 403);
}

TEST_F(BehindBalancer, MalformedHeadersCloseTheConnection) {
  options.limits.request_time = std::chrono::milliseconds(500);
  start();
  for (const std::string& header : malformed_headers()) {
    Client client(port());
    client.send(header);
    EXPECT_EQ(client.read(1), "") << header;
  }
  Client silent(port());
  EXPECT_TRUE(silent.is_closed()) << "the header has request_time";
}

TEST_F(BehindBalancer, ConnectionsAreLimitedByClient) {
  options.limits.connections_per_address = 1;
  start();
  Client first(port()), second(port()), other(port());
  first.send(header_of("192.0.2.7"));
  EXPECT_EQ(first.request("GET", "/healthz").status, 200);
  second.send(header_of("192.0.2.7"));
  EXPECT_EQ(second.receive().status, 429);
  EXPECT_TRUE(second.is_closed());
  other.send(header_of("192.0.2.8"));
  EXPECT_EQ(other.request("GET", "/healthz").status, 200);
  first.reset();
  EXPECT_TRUE(eventually([&] {
    Client again(port());
    again.send(header_of("192.0.2.7"));
    return again.request("GET", "/healthz").status == 200;
  }));
}

TEST_F(BehindProxy, MalformedRangesAreRefused) {
  options.trusted_proxies = {"10.0.0.1/8"};
  const auto started = Server::start(options);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().status, Status::invalid_argument);
  EXPECT_NE(started.error().message.find("expected 10.0.0.0/8"), std::string::npos);
}

}  // namespace
}  // namespace isosplat::server::test
