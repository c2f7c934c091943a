// A request is routed once, however often its handler runs.

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "server/routes/router.h"
#include "server/routes/work_turn.h"
#include "tests/server/test_store.h"

namespace isosplat::server::test {
namespace {

TEST(RoutedCalls, AdmitTheClientOnce) {
  constexpr int kStores = 2 * kHeadersPerTurn + 1;
  const TemporaryFolder folder;
  write_file(folder.path() / "scan-0.isosplat", make_store(1, {5, 5, 5}, 10).file);
  for (int i = 1; i < kStores; ++i) {
    std::filesystem::create_hard_link(folder.path() / "scan-0.isosplat",
                                      folder.path() / ("scan-" + std::to_string(i) + ".isosplat"));
  }
  const auto ignore = [](std::string_view) {};
  Catalog catalog({folder.path()}, ignore);
  StorePool stores({.stores = 1, .directory_bytes = 1 << 20}, ignore);
  ScenePool scenes({}, ScenePool::OutsideLinks::followed, ignore);
  catalog.scan();
  Router router(catalog, stores, scenes, RouterLimits{});
  Request request;
  request.method = Method::get;
  request.target = "/v1/volumes?query=scan";
  int asked = 0;
  const auto admit = [&](const std::string&) -> std::optional<Response> {
    ++asked;
    return std::nullopt;
  };
  RoutedCall call = router.route(request, admit);

  // From now on, new requests without the token may read nothing; this request was admitted before.
  const auto rules = std::make_shared<AccessRules>();
  ASSERT_TRUE(rules->add_lines("0123456789abcdef0123456789abcdef *\n"));
  router.set_access(rules);
  NoWait no_wait;
  call.respond(ThreadKind::connection, &no_wait);
  EXPECT_TRUE(no_wait.needs_disk);
  Response response;
  WorkTurn turn;
  int turns = 0;
  do {
    turn.is_unfinished = false;
    response = call.respond(ThreadKind::disk, nullptr, &turn);
    ++turns;
  } while (turn.is_unfinished && turns < 100);
  EXPECT_EQ(turns, 3);
  EXPECT_EQ(asked, 1);
  const std::string total = "{\"total\":" + std::to_string(kStores) + ",";
  EXPECT_EQ(response.text.substr(0, total.size()), total);
  EXPECT_NE(router.respond(request).text.substr(0, total.size()), total);
}

}  // namespace
}  // namespace isosplat::server::test
