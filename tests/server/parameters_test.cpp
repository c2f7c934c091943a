// The query of each route. Parameters that the table of routes does not name are refused, so that
// each resource has one URL, and a cache in front of the server keeps one copy of it.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/routes/routes.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

class RouteParameters : public ServerTest {
 protected:
  /// A server with alpha, and a scene of it.
  void start_with_scene() {
    write_file(folder.path() / "alpha.scene.json",
               R"({"format":"isosplat-scene","version":1,"layers":[{"store":"alpha.isosplat"}]})");
    start();
    const Answer scene = ask("/v1/scenes/alpha.scene");
    ASSERT_EQ(scene.status, 200) << scene.body;
    scene_content = nlohmann::json::parse(scene.body)["contentId"];
  }

  /// The path of a route, with alpha's first chunk and page.
  std::string path_of(const Route& route) const {
    std::string path(route.pattern);
    const KnownChunk& chunk = alpha.chunks.front();
    const auto fill = [&](const std::string& placeholder, const std::string& value) {
      const size_t at = path.find(placeholder);
      if (at != path.npos) path.replace(at, placeholder.size(), value);
    };
    const bool is_scene = route.kind() == ServedKind::scene;
    fill("{name}", is_scene ? "alpha.scene" : "alpha");
    fill("{content}", is_scene ? scene_content : alpha.content);
    fill("{page}", "0");
    fill("{level}/{x}.{y}.{z}/{band}", place_of(chunk));
    return path;
  }

  /// A query with the required parameters of the route.
  static std::string query_of(const Route& route) {
    std::string query;
    for (const QueryParameter& parameter : route.parameters) {
      if (!parameter.is_required) continue;
      query += query.empty() ? "?" : "&";
      query += std::string(parameter.name) + "=";
      query += parameter.name == "chunks" ? "0/0.0.0/0" : parameter.name == "level" ? "0" : "1";
    }
    return query;
  }

  Answer ask(const std::string& target) const { return get(port(), target); }

  std::string scene_content;
};

TEST_F(RouteParameters, ParametersThatTheTableLacksAreRefusedOnEveryRoute) {
  start_with_scene();
  for (const Route& route : routes()) {
    if (route.operation.empty()) continue;  // the page, and paths that do not exist
    const std::string path = path_of(route), query = query_of(route);
    const char* const more = query.empty() ? "?" : "&";
    EXPECT_NE(ask(path + query).status, 400) << path << query;
    for (const char* bad : {"r=1", "r", "r=", "=", "=1", "sig=x", "exp=1", "token=x", "ISOVALUE=1",
                            "volume=alpha", "%00=1"}) {
      const Answer answer = ask(path + query + more + bad);
      EXPECT_EQ(answer.status, 400) << path << query << more << bad;
      EXPECT_EQ(answer.header("cache-control"), "no-store");
      EXPECT_EQ(nlohmann::json::parse(answer.body)["status"], "invalid_argument");
    }
    // Characters without meaning, and escapes that no client needs.
    for (const std::string& same :
         query.empty() ? std::vector<std::string>{path + "?", path + "?&", path + "?&&"}
                       : std::vector<std::string>{path + query + "&", path + query + "&&",
                                                  path + "?&" + query.substr(1)}) {
      EXPECT_EQ(ask(same).status, 400) << same;
    }
    std::string escaped = path + query;
    const size_t last = escaped.find_last_of("abcdefghijklmnopqrstuvwxyz0123456789");
    escaped.replace(last, 1, fmt::format("%{:02x}", static_cast<unsigned char>(escaped[last])));
    EXPECT_EQ(ask(escaped).status, 400) << escaped;
    for (const QueryParameter& parameter : route.parameters) {
      const std::string twice = std::string(parameter.name) + "=0";
      EXPECT_EQ(ask(path + query + more + twice + "&" + twice).status, 400) << path << twice;
    }
    for (const QueryParameter& parameter : route.parameters) {
      if (parameter.is_required) {
        EXPECT_EQ(ask(path).status, 400) << path;
      }
    }
  }
}

TEST_F(RouteParameters, MessagesNameWhatIsExpectedAndFound) {
  start();
  EXPECT_EQ(nlohmann::json::parse(ask(content("header?r=1")).body)["message"],
            "header: expected no parameter; found \"r\"");
  EXPECT_EQ(nlohmann::json::parse(ask(content("chunks?level=0")).body)["message"],
            "chunks: expected isovalue=a..b, level=L and optionally blocks=x.y.z,…, each at most "
            "once, and no other parameter; missing: \"isovalue\"");
  EXPECT_EQ(nlohmann::json::parse(ask("/v1/volumes?limit=1&limit=1").body)["message"],
            "volumes: expected optionally query=words, offset=n, limit=n, each at most once, and "
            "no other parameter; found twice: \"limit\"");
}

TEST_F(RouteParameters, HashedFilesOfThePageHaveNoParameters) {
  TemporaryFolder page;
  std::filesystem::create_directory(page.path() / "assets");
  write_file(page.path() / "assets/app-0123abcd.js", std::string_view("1"));
  write_file(page.path() / "viewer.js", std::string_view("2"));
  write_file(page.path() / "index.html", std::string_view("<title>I</title>"));
  options.web_root = page.path();
  start();
  EXPECT_EQ(ask("/assets/app-0123abcd.js").header("cache-control"),
            "public, max-age=31536000, immutable");
  EXPECT_EQ(ask("/assets/app-0123abcd.js?r=1").status, 400);
  EXPECT_EQ(ask("/%61ssets/app-0123abcd.js").status, 400);
  // These files are revalidated, and the program of the page interprets the query.
  EXPECT_EQ(ask("/?r=1&&%zz").status, 200);
  EXPECT_EQ(ask("/viewer.js?v=2").status, 200);
}

}  // namespace
}  // namespace isosplat::server::test
