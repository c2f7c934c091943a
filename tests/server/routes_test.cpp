// The table of routes: it equals that of HTTP.md, and paths match the right routes.

#include "server/routes/routes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <sstream>

namespace isosplat::server {
namespace {

struct DocumentedRoute {
  std::string method, pattern;
  std::vector<std::string> parameters;
};

std::string text_of_cell(const std::string& cell) {
  const size_t begin = cell.find_first_not_of(" `");
  return begin == cell.npos ? "" : cell.substr(begin, cell.find_last_not_of(" `") - begin + 1);
}

/// The names in a query such as "?isovalue=a..b[&level=L]".
std::vector<std::string> names_of(const std::string& query) {
  const std::regex name("[?&](\\w+)=");
  std::vector<std::string> names;
  for (auto match = std::sregex_iterator(query.begin(), query.end(), name);
       match != std::sregex_iterator(); ++match) {
    names.push_back((*match)[1]);
  }
  return names;
}

/// The lines of HTTP.md's first table.
std::vector<DocumentedRoute> documented_routes() {
  std::ifstream document(ISOSPLAT_SOURCE_DIR "/server/HTTP.md");
  std::vector<DocumentedRoute> routes;
  bool is_in_table = false;
  for (std::string line; std::getline(document, line);) {
    std::istringstream row(line);
    std::string none, method, url;
    std::getline(std::getline(std::getline(row, none, '|'), method, '|'), url, '|');
    method = text_of_cell(method);
    if (method == "method") {
      is_in_table = true;
    } else if (is_in_table && line.empty()) {
      break;
    } else if (is_in_table && !method.starts_with('-')) {
      url = text_of_cell(url);
      const size_t end = std::min(url.find_first_of("[?"), url.size());
      const std::vector<std::string> parameters = names_of(url.substr(end));
      url.resize(end);
      constexpr std::string_view kAsAbove = "…";
      if (url.starts_with(kAsAbove)) url.replace(0, kAsAbove.size(), "/v1/volumes/{name}");
      routes.push_back({method, url, parameters});
    }
  }
  return routes;
}

TEST(Routes, AreThoseOfTheDocumentInItsOrder) {
  const std::vector<DocumentedRoute> documented = documented_routes();
  ASSERT_EQ(documented.size(), routes().size());
  for (size_t i = 0; i < documented.size(); ++i) {
    EXPECT_EQ(documented[i].pattern, routes()[i].pattern);
    EXPECT_EQ(documented[i].method, "GET");
    std::vector<std::string> parameters;
    for (const QueryParameter& parameter : routes()[i].parameters) {
      parameters.emplace_back(parameter.name);
    }
    EXPECT_EQ(documented[i].parameters, parameters) << documented[i].pattern;
    EXPECT_EQ(routes()[i].method, Method::get);
  }
}

TEST(Routes, APathMatchesTheFirstFittingRoute) {
  using Arguments = std::vector<std::string_view>;
  struct Case {
    const char* path;
    const char* pattern;
    Arguments arguments;
  };
  for (const Case& expected : std::initializer_list<Case>{
           {"/healthz", "/healthz", {}},
           {"/healthz/", "/…", {}},
           {"/v1", "/v1/…", {}},
           {"/v1/volumes", "/v1/volumes", {}},
           {"/v1/volumes/engine", "/v1/volumes/{name}", {"engine"}},
           {"/v1/volumes/engine/bootstrap", "/v1/volumes/{name}/bootstrap", {"engine"}},
           {"/v1/volumes/engine/5e0c", "/v1/…", {}},
           {"/v1/volumes/bootstrap/5e0c/header",
            "/v1/volumes/{name}/{content}/header",
            {"bootstrap", "5e0c"}},
           {"/v1/volumes/engine/5e0c/pages/7",
            "/v1/volumes/{name}/{content}/pages/{page}",
            {"engine", "5e0c", "7"}},
           {"/v1/volumes/engine/5e0c/chunks",
            "/v1/volumes/{name}/{content}/chunks",
            {"engine", "5e0c"}},
           {"/v1/volumes/engine/5e0c/chunks/2/1.0.3/9",
            "/v1/volumes/{name}/{content}/chunks/{level}/{x}.{y}.{z}/{band}",
            {"engine", "5e0c", "2", "1.0.3", "9"}},
           {"/v1/volumes/engine/5e0c/chunks/2/1.0.3/9/1", "/v1/…", {}},
           {"/v1/volumes/engine/5e0c/chunks/2", "/v1/…", {}},
           {"/v2", "/…", {}},
           {"/", "/…", {}},
           {"/assets/a.js", "/…", {}}}) {
    const Result<Target> target = parse_target(expected.path);
    ASSERT_TRUE(target);
    for (const Method method : {Method::get, Method::head}) {
      Arguments arguments;
      const Route* const route = find_route(method, *target, arguments);
      ASSERT_NE(route, nullptr) << expected.path;
      EXPECT_EQ(route->pattern, expected.pattern) << expected.path;
      if (!expected.arguments.empty()) {
        EXPECT_EQ(arguments, expected.arguments) << expected.path;
      }
    }
    Arguments arguments;
    EXPECT_EQ(find_route(Method::other, *target, arguments), nullptr);
  }
}

}  // namespace
}  // namespace isosplat::server
