// The access log: its formats, request ids, text that is left out, and the file.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "server/access/access_rules.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

AccessEntry entry() {
  AccessEntry entry;
  entry.time = std::chrono::system_clock::time_point(std::chrono::milliseconds(1'795'385'412'345));
  entry.id = "abc";
  entry.address = "192.0.2.7";
  entry.method = "GET";
  entry.target = "/v1/volumes";
  entry.route = "/v1/volumes";
  entry.status = 200;
  entry.bytes = 12;
  entry.duration = std::chrono::microseconds(1500);
  return entry;
}

TEST(AccessLines, HaveTheFormsOfTheDocument) {
  EXPECT_EQ(access_line(entry(), LogFormat::plain), "192.0.2.7 GET /v1/volumes 200 12 2ms");
  EXPECT_EQ(access_line(entry(), LogFormat::common),
            "192.0.2.7 - - [22/Nov/2026:22:10:12 +0000] \"GET /v1/volumes HTTP/1.1\" 200 12 abc");
  EXPECT_EQ(access_line(entry(), LogFormat::json),
            "{\"time\":\"2026-11-22T22:10:12.345Z\",\"id\":\"abc\",\"address\":\"192.0.2.7\","
            "\"client\":\"\",\"method\":\"GET\",\"target\":\"/v1/volumes\","
            "\"route\":\"/v1/volumes\",\"status\":200,\"bytes\":12,\"ms\":1.500}");
  AccessEntry named = entry();
  named.client = "ward-3";
  EXPECT_EQ(access_line(named, LogFormat::plain), "192.0.2.7 GET /v1/volumes 200 12 2ms ward-3");
  EXPECT_TRUE(access_line(named, LogFormat::common).starts_with("192.0.2.7 - ward-3 ["));
  EXPECT_EQ(nlohmann::json::parse(access_line(named, LogFormat::json))["client"], "ward-3");
}

TEST(AccessLines, EscapeControlCharactersAndOmitSecrets) {
  AccessEntry hostile = entry();
  hostile.method = "G\"ET";
  hostile.target = "/a\"b\\\x01\n\x7f\xc3\xa4?token=secret&sig=hidden&exp=1";
  for (const LogFormat format : {LogFormat::plain, LogFormat::common, LogFormat::json}) {
    const std::string line = access_line(hostile, format);
    for (const char c : line) EXPECT_TRUE(c >= 0x20 && c < 0x7f) << line;
    EXPECT_EQ(line.find("secret"), std::string::npos) << line;
    EXPECT_EQ(line.find("hidden"), std::string::npos) << line;
  }
  const auto json = nlohmann::json::parse(access_line(hostile, LogFormat::json));
  EXPECT_EQ(json["method"], "G\\x22ET");
  const std::string common = access_line(hostile, LogFormat::common);
  EXPECT_EQ(std::ranges::count(common, '"'), 2) << common;
}

TEST(RequestIds, AreAcceptedIfTheyAreHarmless) {
  for (const char* id : {"a", "0f8fad5b-d9cb-469f-a165-70867728950e", "A_b.C-9"}) {
    EXPECT_EQ(request_id(id), id);
  }
  EXPECT_TRUE(is_request_id(std::string(kMaxRequestId, 'x')));
  std::set<std::string> made;
  for (const std::string& bad :
       {std::string(), std::string("a b"), std::string("a\r\nX: y"), std::string("\"x\""),
        std::string("ä"), std::string(1, '\0'), std::string(kMaxRequestId + 1, 'x')}) {
    const std::string id = request_id(bad);
    EXPECT_TRUE(is_request_id(id));
    EXPECT_NE(id, bad);
    EXPECT_TRUE(made.insert(id).second) << "twice: " << id;
  }
}

class AccessLog : public ServerTest {
 protected:
  static constexpr size_t npos = std::string::npos;
  const std::filesystem::path path = folder.path() / "access.log";
};

TEST_F(AccessLog, IsAppendedToAFile) {
  write_file(path, "an older line\n");
  options.access_log_file = path;
  options.log_format = LogFormat::json;
  const std::string token = "0123456789abcdef-token";
  options.tokens = {token};
  start();
  Client client(port());
  const Answer with_id = client.request("GET", "/v1/volumes/alpha",
                                        "X-Request-Id: from-the-proxy\r\nCookie: isosplat-" +
                                            std::to_string(port()) + "=" + token + "\r\n");
  EXPECT_EQ(with_id.status, 200);
  EXPECT_EQ(with_id.header("x-request-id"), "from-the-proxy");
  const Answer without = client.request("GET", "/?token=" + token);
  EXPECT_EQ(without.status, 303);
  EXPECT_EQ(without.header("x-request-id"), "");
  const Answer hostile = client.request("GET", "/healthz", "X-Request-Id: a b\"c\r\n");
  EXPECT_EQ(hostile.header("x-request-id"), "");
  server.reset();

  const std::vector<std::string> lines = lines_of(path);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0], "an older line");
  const auto first = nlohmann::json::parse(lines[1]);
  EXPECT_EQ(first["id"], "from-the-proxy");
  EXPECT_EQ(first["address"], "127.0.0.1");
  EXPECT_EQ(first["target"], "/v1/volumes/alpha");
  EXPECT_EQ(first["route"], "/v1/volumes/{name}");
  EXPECT_EQ(first["status"], 200);
  EXPECT_EQ(first["bytes"], with_id.body.size());
  const auto second = nlohmann::json::parse(lines[2]);
  EXPECT_TRUE(std::regex_match(second["id"].get<std::string>(), std::regex("[0-9a-f]{16}")));
  EXPECT_TRUE(is_request_id(nlohmann::json::parse(lines[3])["id"].get<std::string>()));
  for (const std::string& line : lines) EXPECT_EQ(line.find(token), std::string::npos) << line;
}

TEST_F(AccessLog, IsOpenedAnewByAReload) {
  options.access_log_file = path;
  options.log_format = LogFormat::common;
  start();
  get(port(), "/healthz");
  const auto moved = folder.path() / "access.log.1";
  EXPECT_TRUE(eventually([&] { return lines_of(path).size() == 1; }));
  std::filesystem::rename(path, moved);
  get(port(), "/v1/volumes");
  EXPECT_TRUE(eventually([&] { return lines_of(moved).size() == 2; }));
  EXPECT_TRUE(server->reload());
  get(port(), "/readyz");
  EXPECT_TRUE(eventually([&] { return lines_of(path).size() == 1; }));
  EXPECT_NE(lines_of(path)[0].find("/readyz"), std::string::npos);
  const auto mode = std::filesystem::status(path).permissions();
  EXPECT_EQ(mode & std::filesystem::perms::others_all, std::filesystem::perms::none);
}

TEST_F(AccessLog, AFileThatCannotBeOpenedIsAnError) {
  options.access_log_file = folder.path() / "no" / "such.log";
  const auto started = Server::start(options);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().status, Status::io_error);
}

TEST_F(AccessLog, HasTheNameOfTheTokenAndNotTheToken) {
  const std::string named = "0123456789abcdef-named", other = "0123456789abcdef-other";
  write_file(folder.path() / "tokens",
             named + " name=ward-3 alpha\n# comment\n" + other + " *\nanyone open\n");
  options.token_file = folder.path() / "tokens";
  options.tokens = {"0123456789abcdef-first"};
  options.link_key = std::string(32, 'k');
  options.access_log_file = path;
  options.log_format = LogFormat::json;
  start();
  const auto bearer = [](const std::string& token) {
    return "Authorization: Bearer " + token + "\r\n";
  };
  get(port(), "/v1/volumes", bearer(named));
  get(port(), "/v1/volumes", bearer(other));
  get(port(), "/v1/volumes", bearer(options.tokens[0]));
  get(port(), "/v1/volumes/alpha?exp=4000000000&sig=" +
                  sign_link(options.link_key, ServedKind::volume, "alpha", "4000000000"));
  get(port(), "/v1/volumes", bearer("0123456789abcdef-wrong"));
  get(port(), "/v1/volumes");
  server.reset();
  std::vector<std::string> clients;
  for (const std::string& line : lines_of(path)) {
    EXPECT_EQ(line.find("0123456789abcdef"), line.npos) << line;
    clients.push_back(nlohmann::json::parse(line)["client"]);
  }
  // Each request is logged by its connection, after the response.
  std::ranges::sort(clients);
  EXPECT_EQ(clients,
            (std::vector<std::string>{"", "", "ISOSPLAT_TOKEN", "line-3", "link", "ward-3"}));
}

TEST_F(AccessLog, HasConnectionsThatWereRefused) {
  options.access_log_file = path;
  options.log_format = LogFormat::common;
  options.limits.connections_per_address = 2;
  start();
  std::vector<Client> open;
  for (int i = 0; i < 2; ++i) {
    open.emplace_back(port());
    EXPECT_EQ(open.back().request("GET", "/healthz").status, 200);
  }
  Client refused(port());
  EXPECT_EQ(refused.receive().status, 429);
  EXPECT_TRUE(eventually([&] {
    return open[0]
               .request("GET", "/metrics")
               .body.find("isosplat_http_requests_total{route=\"none\",status=\"429\"} 1\n") !=
           npos;
  }));
  server.reset();
  const auto lines = lines_of(path);
  EXPECT_EQ(std::ranges::count_if(
                lines, [](const auto& line) { return line.find("\"- - HTTP/1.1\" 429 ") != npos; }),
            1);
}

}  // namespace
}  // namespace isosplat::server::test
