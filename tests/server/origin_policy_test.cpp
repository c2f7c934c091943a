// Who may read: the names that a request may give to the server, and the pages of other origins.

#include "server/access/origin_policy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;

/// A request over a socket, and the expected response.
struct Row {
  const char* target;
  const char* headers;  ///< with Host
  int status;
  const char* name = "";         ///< of the error
  const char* readable_by = "";  ///< Access-Control-Allow-Origin
  const char* method = "GET";
};

class Origins : public ServerTest {
 protected:
  /// Sends the headers as they are: Client::request() would add a Host.
  Answer send(const Row& row) const {
    Client client(port());
    client.send(std::string(row.method) + " " + row.target + " HTTP/1.1\r\n" + row.headers +
                "\r\n");
    return client.receive();
  }

  void expect(const std::vector<Row>& rows) const {
    for (const Row& row : rows) {
      SCOPED_TRACE(std::string(row.target) + " " + row.headers);
      const Answer answer = send(row);
      EXPECT_EQ(answer.status, row.status) << answer.body;
      EXPECT_EQ(answer.header("access-control-allow-origin"), row.readable_by);
      const std::string exposed = answer.header("access-control-expose-headers");
      EXPECT_EQ(exposed.empty(), *row.readable_by == 0);
      // Without it, a page takes the length of the compressed body for that of the body.
      EXPECT_TRUE(exposed.empty() || exposed.find("Content-Encoding") != exposed.npos) << exposed;
      EXPECT_EQ(answer.header("timing-allow-origin"), row.readable_by);
      if (*row.name == 0) continue;
      const Json body = Json::parse(answer.body, nullptr, false);
      ASSERT_TRUE(body.is_object()) << answer.body;
      EXPECT_EQ(body["status"], row.name);
      EXPECT_EQ(answer.header("cache-control"), "no-store");
      EXPECT_EQ(answer.body.find("alpha"), std::string::npos) << "nothing of a volume";
    }
  }
};

constexpr const char* kList = "/v1/volumes";
constexpr const char* kBadHost = "forbidden_host";
constexpr const char* kBadOrigin = "forbidden_origin";

TEST_F(Origins, ALocalServerHasLocalNamesOnly) {
  options.allowed_hosts = {"Lab.example"};
  start();
  expect({{kList, "Host: localhost\r\n", 200},
          {kList, "Host: localhost:8080\r\n", 200},
          {kList, "Host: LOCALHOST:1\r\n", 200},
          {kList, "Host: 127.0.0.1:8080\r\n", 200},
          {kList, "Host: [::1]:8080\r\n", 200},
          {kList, "Host: lab.EXAMPLE:8080\r\n", 200},
          {kList, "Host: evil.example\r\n", 403, kBadHost},
          {kList, "Host: evil.example:8080\r\n", 403, kBadHost},
          {kList, "Host: localhost.evil.example\r\n", 403, kBadHost},
          {kList, "Host: localhost:8080.evil.example\r\n", 403, kBadHost},
          {kList, "Host: localhost:80:80\r\n", 403, kBadHost},
          {kList, "Host: user@localhost\r\n", 403, kBadHost},
          {kList, "Host: 192.168.1.5\r\n", 403, kBadHost},
          {kList, "Host: [::2]\r\n", 403, kBadHost},
          {kList, "Host: [::1\r\n", 403, kBadHost},
          {kList, "Host:\r\n", 403, kBadHost},
          {"/", "Host: evil.example\r\n", 403, kBadHost},
          {"/healthz", "Host: evil.example\r\n", 403, kBadHost},
          {kList, "Host: evil.example\r\n", 403, kBadHost, "", "OPTIONS"},
          {"/v1/none", "Host: evil.example\r\n", 403, kBadHost},
          // The host of an absolute target counts.
          {"http://localhost:8080/v1/volumes", "Host: evil.example\r\n", 200},
          {"http://evil.example/v1/volumes", "Host: localhost\r\n", 403, kBadHost}});
  // Browsers always send Host; programs that speak HTTP/1.0 need not.
  Client old(port());
  old.send("GET /v1/volumes HTTP/1.0\r\n\r\n");
  EXPECT_EQ(old.receive().status, 200);
}

TEST_F(Origins, ALocalServerIsReadByItsOwnPageOnly) {
  start();
  const std::string own = "Host: localhost:8080\r\nOrigin: http://localhost:8080\r\n";
  expect({{kList, own.c_str(), 200},
          {kList, "Host: localhost:8080\r\nSec-Fetch-Site: same-origin\r\n", 200},
          {kList, "Host: localhost:8080\r\nSec-Fetch-Site: none\r\n", 200},
          // A proxy may change the Host: then the fields of the browser decide.
          {kList, "Host: localhost\r\nOrigin: http://a.example\r\nSec-Fetch-Site: same-origin\r\n",
           200},
          {kList, "Host: localhost\r\nOrigin: https://LOCALHOST:443\r\n", 200},
          {kList, "Host: localhost\r\nOrigin: https://evil.example\r\n", 403, kBadOrigin},
          {kList, "Host: localhost:8080\r\nOrigin: http://localhost:3000\r\n", 403, kBadOrigin},
          {kList, "Host: localhost\r\nOrigin: null\r\n", 403, kBadOrigin},
          {kList, "Host: localhost\r\nOrigin: http://localhost.evil.example\r\n", 403, kBadOrigin},
          {kList, "Host: localhost\r\nSec-Fetch-Site: cross-site\r\n", 403, kBadOrigin},
          {kList, "Host: localhost\r\nSec-Fetch-Site: same-site\r\n", 403, kBadOrigin},
          {kList, "Host: localhost\r\nOrigin: https://evil.example\r\n", 403, kBadOrigin, "",
           "OPTIONS"},
          {"/healthz", "Host: localhost\r\nSec-Fetch-Site: cross-site\r\n", 403, kBadOrigin},
          {"/v1/none", "Host: localhost\r\nSec-Fetch-Site: cross-site\r\n", 403, kBadOrigin}});
  // A link from another site to the page works: the page has nothing of a volume.
  EXPECT_EQ(send({"/", "Host: localhost\r\nSec-Fetch-Site: cross-site\r\n", 200}).status, 200);
  // Elements of other sites' pages (img, script) may not load the data either.
  EXPECT_EQ(get(port(), kList).header("cross-origin-resource-policy"), "same-origin");
  // Volumes and their content, too.
  for (const std::string& target :
       {content("header"), content("file"), content("chunks?isovalue=100&level=0")}) {
    EXPECT_EQ(get(port(), target).status, 200);
    EXPECT_EQ(get(port(), target, "Origin: https://evil.example\r\n").status, 403);
  }
}

TEST_F(Origins, ListedOriginsMayRead) {
  options.cross_origin = *parse_cross_origin("https://a.example,http://b.example:80");
  start();
  expect({{kList, "Host: localhost\r\nOrigin: https://a.example\r\n", 200, "", "https://a.example"},
          {kList, "Host: localhost\r\nOrigin: http://b.example\r\nSec-Fetch-Site: cross-site\r\n",
           200, "", "http://b.example"},
          {"/v1/volumes/none", "Host: localhost\r\nOrigin: https://a.example\r\n", 404, "not_found",
           "https://a.example"},
          {kList, "Host: localhost\r\n", 200},
          {kList, "Host: localhost\r\nOrigin: https://c.example\r\n", 403, kBadOrigin},
          {kList, "Host: localhost\r\nOrigin: http://a.example\r\n", 403, kBadOrigin},
          {kList, "Host: evil.example\r\nOrigin: https://a.example\r\n", 403, kBadHost,
           "https://a.example"}});
  const Answer preflight =
      send({kList, "Host: localhost\r\nOrigin: https://a.example\r\n", 204, "", "", "OPTIONS"});
  EXPECT_EQ(preflight.status, 204);
  EXPECT_EQ(preflight.header("access-control-allow-origin"), "https://a.example");
  EXPECT_EQ(preflight.header("vary"), "Origin");
  // A cache that holds a response without the field must not give it to the other page.
  const std::multimap<std::string, std::string> fields = get(port(), kList).headers;
  EXPECT_TRUE(std::any_of(fields.begin(), fields.end(), [](const auto& field) {
    return field.first == "vary" && field.second == "Origin";
  }));
}

TEST_F(Origins, EveryPageMayReadPublicVolumes) {
  options.is_public = true;
  start();
  expect({{kList, "Host: any.example\r\nOrigin: https://a.example\r\n", 200, "", "*"},
          {kList, "Host: localhost\r\nSec-Fetch-Site: cross-site\r\n", 200, "", "*"},
          {kList, "Host: localhost\r\nOrigin: null\r\n", 200, "", "*"}});
  EXPECT_EQ(get(port(), kList).header("cross-origin-resource-policy"), "cross-origin");
  EXPECT_EQ(get(port(), kList).header("vary"), "Accept-Encoding") << "the same for every page";
}

TEST_F(Origins, OnOtherAddressesTheOperatorMustChoose) {
  options.host = "0.0.0.0";
  const auto refused = Server::start(options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().status, Status::invalid_argument);
  for (const char* choice : {"--cors none", "--cors https://", "--cors '*'", "--public"}) {
    EXPECT_NE(refused.error().message.find(choice), std::string::npos) << choice;
  }
  options.cross_origin = CrossOrigin{};
  start();
  EXPECT_TRUE(will_log("warning: everyone who reaches 0.0.0.0"));
  // An attacker's page can have a host name that resolves to this machine's address (DNS
  // rebinding), but its host cannot be the address itself.
  expect({{kList, "Host: 192.168.1.5:8080\r\n", 200},
          {kList, "Host: [fe80::1]\r\n", 200},
          {kList, "Host: localhost\r\n", 200},
          {kList, "Host: evil.example\r\n", 403, kBadHost},
          {kList, "Host: 1.2.3.4.evil.example\r\n", 403, kBadHost},
          {kList, "Host: 192.168.1.5\r\nSec-Fetch-Site: cross-site\r\n", 403, kBadOrigin}});
}

TEST_F(Origins, InvalidChoicesAreRefused) {
  for (const char* text :
       {"", "a.example", "https://", "https://a.example/", "https://a.example/p",
        "*,https://a.example", "https://*.example", "https://a.example,", "https://a b",
        "ftp://a.example", "https://u@a.example", "https://a:x", "https://a\r\nb"}) {
    EXPECT_FALSE(parse_cross_origin(text)) << text;
  }
  EXPECT_TRUE(parse_cross_origin("none")->origins.empty());
  EXPECT_TRUE(parse_cross_origin("*")->any);
  EXPECT_EQ(parse_cross_origin("https://A.example:443,http://[::1]:8080")->origins,
            (std::vector<std::string>{"https://a.example", "http://[::1]:8080"}));
}

}  // namespace
}  // namespace isosplat::server::test
