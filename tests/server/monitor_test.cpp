// /metrics and /readyz: who may read them, and whether the numbers count what happened.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "server/routes/routes.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

/// The samples of a text in the format of Prometheus, by name and labels as written. Also checks
/// the grammar: the type of each sample is declared before it, and values are numbers.
std::map<std::string, double> samples_of(const std::string& text) {
  std::map<std::string, double> samples;
  std::map<std::string, std::string> types;
  EXPECT_TRUE(text.ends_with('\n'));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string first, second, name, type;
    words >> first;
    if (first == "#") {
      words >> second >> name >> type;
      EXPECT_TRUE(second == "HELP" || second == "TYPE") << line;
      if (second == "TYPE") {
        EXPECT_TRUE(types.emplace(name, type).second) << "declared twice: " << line;
      }
      continue;
    }
    const size_t end = line.rfind(' ');
    const std::string key = line.substr(0, end);
    name = key.substr(0, key.find('{'));
    for (const char* suffix : {"_bucket", "_sum", "_count"}) {
      const size_t at = name.size() - std::min(name.size(), std::string(suffix).size());
      if (name.substr(at) == suffix && types[name.substr(0, at)] == "histogram") name.resize(at);
    }
    EXPECT_TRUE(types.contains(name)) << line;
    EXPECT_EQ(name.ends_with("_total"), types[name] == "counter") << line;
    size_t used = 0;
    const std::string value = line.substr(end + 1);
    EXPECT_TRUE(samples.emplace(key, std::stod(value, &used)).second) << "twice: " << line;
    EXPECT_EQ(used, value.size()) << line;
  }
  return samples;
}

class Monitoring : public ServerTest {
 protected:
  std::map<std::string, double> samples(Client& client) {
    const Answer answer = client.request("GET", "/metrics");
    EXPECT_EQ(answer.status, 200) << answer.body;
    EXPECT_EQ(answer.header("content-type"), "text/plain; version=0.0.4; charset=utf-8");
    EXPECT_EQ(answer.header("cache-control"), "no-store");
    return samples_of(answer.body);
  }
};

TEST_F(Monitoring, CountsRequestsByRouteAndStatus) {
  write_file(folder.path() / "broken.isosplat", "no store");
  start();
  Client client(port());
  for (int i = 0; i < 3; ++i) client.request("GET", "/v1/volumes/alpha");
  client.request("GET", "/v1/volumes/beta");
  const Answer file = client.request("GET", content("file"));
  client.request("GET", content("file"), "If-None-Match: *\r\n");
  client.send("HEAD " + content("file") + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(client.receive(true).status, 200);
  Client second(port());
  second.send("nonsense\r\n\r\n");
  EXPECT_EQ(second.receive().status, 400);
  EXPECT_TRUE(second.is_closed());

  std::map<std::string, double> found;
  // Waits until the closed connection is no longer counted, and all headers were read.
  EXPECT_TRUE(eventually([&] {
    found = samples(client);
    return found["isosplat_connections_open"] == 1 &&
           found[R"(isosplat_stores{state="unread"})"] == 0;
  }));
  const std::string requests = "isosplat_http_requests_total";
  EXPECT_EQ(found[requests + R"({route="/v1/volumes/{name}",status="200"})"], 3);
  EXPECT_EQ(found[requests + R"({route="/v1/volumes/{name}",status="404"})"], 1);
  EXPECT_EQ(found[requests + R"({route="/v1/volumes/{name}/{content}/file",status="200"})"], 2);
  EXPECT_EQ(found[requests + R"({route="/v1/volumes/{name}/{content}/file",status="304"})"], 1);
  EXPECT_EQ(found[requests + R"({route="none",status="400"})"], 1);
  EXPECT_EQ(
      found
          [R"(isosplat_http_response_body_bytes_total{route="/v1/volumes/{name}/{content}/file"})"],
      static_cast<double>(file.body.size()));
  EXPECT_EQ(found["isosplat_connections_total"], 2);
  EXPECT_EQ(found["isosplat_connections_refused_total"], 0);
  EXPECT_EQ(found[R"(isosplat_stores{state="served"})"], 1);
  EXPECT_EQ(found[R"(isosplat_stores{state="broken"})"], 1);
  EXPECT_EQ(found["isosplat_stores_open"], 1);
  EXPECT_EQ(found["isosplat_stores_opened_total"], 1);
  EXPECT_EQ(found["isosplat_faults_total"], 0);
  EXPECT_GT(found[R"(isosplat_reads_total{from="memory"})"] +
                found[R"(isosplat_reads_total{from="disk"})"],
            5);
  EXPECT_EQ(found["isosplat_disk_reads_waiting"], 0);
  EXPECT_GT(found["process_start_time_seconds"], 1.7e9);
}

TEST_F(Monitoring, HistogramsAreCumulative) {
  start();
  Client client(port());
  for (int i = 0; i < 5; ++i) client.request("GET", "/healthz");
  const auto found = samples(client);
  const std::string name = "isosplat_http_request_duration_seconds";
  std::map<double, double> buckets;
  for (const auto& [key, value] : found) {
    const std::string prefix = name + R"(_bucket{route="/healthz",le=")";
    if (!key.starts_with(prefix)) continue;
    const std::string limit = key.substr(prefix.size(), key.size() - prefix.size() - 2);
    buckets[limit == "+Inf" ? INFINITY : std::stod(limit)] = value;
  }
  ASSERT_GE(buckets.size(), 10u);
  double before = 0;
  for (const auto& [limit, count] : buckets) {
    EXPECT_GE(count, before) << limit;
    before = count;
  }
  EXPECT_EQ(buckets[INFINITY], 5);
  EXPECT_EQ(found.at(name + R"(_count{route="/healthz"})"), 5);
  EXPECT_GE(found.at(name + R"(_sum{route="/healthz"})"), 0);
}

TEST_F(Monitoring, ReportsTheProcessAndItsReloads) {
  options.token_file = folder.path() / "tokens";
  write_file(options.token_file, std::string_view("anyone *\n"));
  start();
  Client client(port());
  auto found = samples(client);
  for (const auto& [name, least] : std::initializer_list<std::pair<const char*, double>>{
           {"process_resident_memory_bytes", 1 << 20},
           {"process_virtual_memory_bytes", 1 << 20},
           {"process_open_fds", 5},
           {"process_max_fds", 64},
           {"process_cpu_seconds_total", 0.001},
           {"isosplat_bytes_in_flight_limit", 1 << 20},
           {"isosplat_last_reload_seconds", 1.7e9}}) {
    EXPECT_GE(found[name], least) << name;
  }
  EXPECT_LE(found["process_open_fds"], static_cast<double>(open_descriptors()));
  EXPECT_EQ(
      std::ranges::count_if(found,
                            [](const auto& each) {
                              return each.first.starts_with("isosplat_build_info{version=\"") &&
                                     each.second == 1;
                            }),
      1);
  EXPECT_EQ(found["isosplat_last_reload_successful"], 1);
  EXPECT_FALSE(found.contains("isosplat_tls_certificate_end_seconds")) << "without TLS";
  write_file(options.token_file, std::string_view("short *\n"));
  EXPECT_FALSE(server->reload());
  found = samples(client);
  EXPECT_EQ(found["isosplat_last_reload_successful"], 0);
  EXPECT_EQ(found[R"(isosplat_reloads_total{result="failure"})"], 1);
  EXPECT_EQ(found[R"(isosplat_reloads_total{result="success"})"], 0);
  write_file(options.token_file, std::string_view("anyone *\n"));
  EXPECT_TRUE(server->reload());
  found = samples(client);
  EXPECT_EQ(found["isosplat_last_reload_successful"], 1);
  EXPECT_EQ(found[R"(isosplat_reloads_total{result="success"})"], 1);
}

TEST_F(Monitoring, CountsFaults) {
  start();
  // A chunk whose bytes are changed in place.
  const KnownChunk& chunk = *std::ranges::max_element(
      alpha.chunks, {}, [](const KnownChunk& each) { return each.bytes.size(); });
  std::vector<std::byte> damaged = alpha.file;
  *std::search(damaged.begin(), damaged.end(), chunk.bytes.begin(), chunk.bytes.end()) ^=
      std::byte{1};
  write_file(folder.path() / "damaged.isosplat", damaged);
  EXPECT_TRUE(will_log("damaged.isosplat, content"));
  Client client(port());
  EXPECT_EQ(
      client.request("GET", "/v1/volumes/damaged/" + alpha.content + "/chunks/" + place_of(chunk))
          .status,
      500);
  EXPECT_EQ(samples(client)["isosplat_faults_total"], 1);
}

TEST_F(Monitoring, MetricsAreNotForProxiedClients) {
  start();
  for (const char* field : {"Forwarded: for=192.0.2.1", "X-Forwarded-For: 192.0.2.1",
                            "X-Real-IP: 192.0.2.1", "via: 1.1 proxy"}) {
    const Answer answer = get(port(), "/metrics", field + std::string("\r\n"));
    EXPECT_EQ(answer.status, 403) << field;
    EXPECT_NE(answer.body.find("forbidden_address"), std::string::npos);
  }
  EXPECT_EQ(get(port(), "/metrics", "Origin: https://evil.example\r\n").status, 403);
}

TEST_F(Monitoring, MetricsAreForNoPageOfAnotherOrigin) {
  const std::string other = "Origin: https://a.example\r\nSec-Fetch-Site: cross-site\r\n";
  for (const bool is_public : {true, false}) {
    server.reset();
    options.is_public = is_public;
    if (!is_public)
      options.cross_origin = CrossOrigin{.any = false, .origins = {"https://a.example"}};
    start();
    EXPECT_EQ(get(port(), "/healthz", other).status, 200);
    EXPECT_NE(get(port(), "/healthz", other).header("access-control-allow-origin"), "");
    EXPECT_EQ(get(port(), "/metrics", other).status, 403);
    for (const std::string& headers : {std::string(), other}) {
      const Answer answer = get(port(), "/metrics", headers);
      EXPECT_EQ(answer.header("access-control-allow-origin"), "");
      EXPECT_EQ(answer.header("cross-origin-resource-policy"), "same-origin");
    }
    EXPECT_EQ(get(port(), "/metrics").status, 200);
  }
}

TEST_F(Monitoring, MetricsAreForTokensOfAllVolumes) {
  const std::string all = "0123456789abcdef-all", one = "0123456789abcdef-one";
  write_file(folder.path() / "tokens", all + " *\n" + one + " alpha\n");
  options.token_file = folder.path() / "tokens";
  start();
  const std::string proxy = "X-Forwarded-For: 192.0.2.1\r\n";
  EXPECT_EQ(get(port(), "/metrics", proxy).status, 401);
  EXPECT_EQ(get(port(), "/metrics", proxy + "Authorization: Bearer " + one + "\r\n").status, 401);
  EXPECT_EQ(get(port(), "/metrics", proxy + "Authorization: Bearer " + all + "\r\n").status, 200);
  EXPECT_EQ(get(port(), "/metrics").status, 200);
  // It contains no secrets and no names.
  const std::string text = get(port(), "/metrics").body;
  for (const std::string& secret : {all, one, std::string("alpha"), std::string("192.0.2.1")}) {
    EXPECT_EQ(text.find(secret), std::string::npos) << secret;
  }
}

TEST_F(Monitoring, IsReadyWhileAStoreCanBeServed) {
  start();
  EXPECT_EQ(get(port(), "/readyz").status, 200);
  EXPECT_EQ(get(port(), "/readyz").body, "{\"status\":\"ready\"}\n");
  write_file(folder.path() / "alpha.isosplat", "no store");
  EXPECT_TRUE(eventually([&] { return get(port(), "/readyz").status == 503; }));
  const Answer answer = get(port(), "/readyz");
  EXPECT_EQ(answer.header("retry-after"), "1");
  EXPECT_NE(answer.body.find("not_ready"), std::string::npos);
  EXPECT_EQ(get(port(), "/healthz").status, 200);
  write_file(folder.path() / "alpha.isosplat", alpha.file);
  EXPECT_TRUE(eventually([&] { return get(port(), "/readyz").status == 200; }));
}

}  // namespace
}  // namespace isosplat::server::test
