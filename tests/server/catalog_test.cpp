// Many stores, in folders and subfolders: the list of volumes, and how it changes with the files.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "server/catalog/catalog.h"
#include "server/catalog/folder_watch.h"
#include "server/catalog/store_pool.h"
#include "server/catalog/volume_names.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;
using Names = std::vector<std::string>;

class ManyStores : public ServerTest {
 protected:
  void write_store(const std::string& path, const KnownStore& store) const {
    std::filesystem::create_directories((folder.path() / path).parent_path());
    write_file(folder.path() / path, store.file);
  }

  /// Makes stores named name-0000 and so on, which are links to one file.
  void link_stores(const std::string& below, int count) const {
    std::filesystem::create_directories(folder.path() / below);
    for (int i = 0; i < count; ++i) {
      std::string number = std::to_string(i);
      number.insert(0, 5 - number.size(), '0');
      std::filesystem::create_hard_link(folder.path() / "alpha.isosplat",
                                        folder.path() / below / ("n" + number + ".isosplat"));
    }
  }

  Json list(const std::string& query = "", const std::string& headers = "") const {
    const Answer answer = get(port(), "/v1/volumes" + query, headers);
    EXPECT_EQ(answer.status, 200) << answer.body;
    return Json::parse(answer.body);
  }

  static Names names_of(const Json& list) {
    Names names;
    for (const Json& volume : list["volumes"]) names.push_back(volume["name"]);
    return names;
  }

  Names names(const std::string& query = "", const std::string& headers = "") const {
    return names_of(list(query, headers));
  }

  bool become(const Names& expected) const {
    return eventually([&] { return names() == expected; });
  }

  int status(const std::string& target) const { return get(port(), target).status; }
};

/// Lowers the limit of file descriptors, so that `spare` more than those in use can be opened.
class FewDescriptors {
 public:
  explicit FewDescriptors(uint64_t spare) {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    uint64_t end = 0;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
      end = std::max<uint64_t>(end, std::stoull(entry.path().filename().string()) + 1);
    }
    // Free descriptors below the last one in use would be spare ones too, so they are taken first.
    set_limit(end);
    for (int file = 0; (file = ::open("/dev/null", O_RDONLY | O_CLOEXEC)) >= 0;) {
      taken_.push_back(file);
    }
    set_limit(end + spare);
  }
  ~FewDescriptors() {
    for (const int file : taken_) ::close(file);
    ::setrlimit(RLIMIT_NOFILE, &before_);
  }

 private:
  void set_limit(uint64_t descriptors) const {
    const rlimit few{descriptors, before_.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &few);
  }
  rlimit before_{};
  std::vector<int> taken_;
};

TEST(Catalog, AFolderThatIsGivenTwiceIsFollowedByBothPaths) {
  TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "real");
  std::filesystem::create_directory_symlink("real", folder.path() / "link");
  FolderWatch watch;
  const std::string real = folder.path() / "real", link = folder.path() / "link";
  if (!watch.add(real)) GTEST_SKIP() << "no inotify";
  EXPECT_FALSE(watch.add(link)) << "its changes are reported for the other path";
  write_file(folder.path() / "real/a.isosplat", "");
  std::vector<FolderChange> changes;
  for (int i = 0; i < 1200 && changes.empty(); ++i) {
    changes = watch.wait(std::chrono::milliseconds(100)).list;
  }
  ASSERT_FALSE(changes.empty());
  EXPECT_EQ(changes.front().folder, real);
  // The server treats both paths as one folder.
  Catalog catalog({folder.path() / "real", folder.path() / "link"}, [](std::string_view) {});
  catalog.scan();
  EXPECT_EQ(catalog.snapshot()->size(), 1u);
  write_file(folder.path() / "real/b.isosplat", "");
  for (int i = 0; i < 1200 && catalog.snapshot()->size() != 2; ++i) {
    catalog.follow(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(catalog.snapshot()->size(), 2u);
  // After a folder was renamed, it can be watched by its new name.
  std::filesystem::remove(folder.path() / "link");
  std::filesystem::rename(folder.path() / "real", folder.path() / "renamed");
  EXPECT_TRUE(watch.add(folder.path() / "renamed"));
}

TEST(Catalog, StoresStayWhenTheirFolderCannotBeListed) {
  TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "ct/old");
  for (const char* const file : {"a.isosplat", "ct/b.isosplat", "ct/old/c.isosplat"}) {
    write_file(folder.path() / file, "");
  }
  Catalog catalog({folder.path()}, [](std::string_view) {});
  catalog.scan();
  const auto before = *catalog.snapshot();
  ASSERT_EQ(before.size(), 3u);
  for (const uint64_t spare : {0, 1}) {  // for no folder, and for the first one alone
    const FewDescriptors few(spare);
    catalog.scan();
    EXPECT_TRUE(*catalog.snapshot() == before) << catalog.snapshot()->size();
  }
  std::filesystem::remove_all(folder.path() / "ct/old");
  for (int i = 0; i < 1200 && catalog.snapshot()->size() != 2; ++i) {
    catalog.follow(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(catalog.snapshot()->size(), 2u);
  EXPECT_TRUE(catalog.snapshot()->at("a") == before.at("a")) << "the same entry all the time";
}

TEST(Catalog, ARemovedStoreDoesNotReduceTheMemoryOfOthers) {
  TemporaryFolder folder;
  for (const char* const name : {"a", "b"}) {
    write_file(folder.path() / (std::string(name) + ".isosplat"), make_store(1).file);
  }
  Catalog catalog({folder.path()}, [](std::string_view) {});
  catalog.scan();
  const auto before = catalog.snapshot();
  uint64_t bytes = 0;
  for (const bool is_last : {false, true}) {
    StorePool pool({.all_directory_bytes = is_last ? bytes : UINT64_MAX}, [](std::string_view) {});
    for (const char* const name : {"b", "a"}) {
      const auto store = pool.open(*before->at(name));
      ASSERT_TRUE(store);
      EXPECT_TRUE((*store)->chunks_for(0, -1e9f, 1e9f, {}));
      bytes = (*store)->directory_bytes();
      ASSERT_GT(bytes, 0u);
    }
    CatalogSnapshot after = *before;
    after.erase("a");  // which was used last
    pool.trim(after);
    EXPECT_EQ(pool.size(), 1u) << "the other one is within the limit";
  }
}

TEST_F(ManyStores, FoldersNamedInOtherScriptsAreDistinguished) {
  const KnownStore first = make_store(2), second = make_store(3);
  write_store("张三/a.isosplat", first);
  write_store("李四/a.isosplat", second);
  start();
  const std::string one = name_segment("张三") + "~a", two = name_segment("李四") + "~a";
  EXPECT_EQ(status("/v1/volumes/" + one + "/" + first.content + "/header"), 200);
  EXPECT_EQ(status("/v1/volumes/" + two + "/" + second.content + "/header"), 200);
  std::filesystem::rename(folder.path() / "李四", folder.path() / "王五");
  std::filesystem::remove_all(folder.path() / "张三");
  EXPECT_TRUE(become({"alpha", name_segment("王五") + "~a"}));
}

TEST_F(ManyStores, StoresOfSubfoldersAreServed) {
  const KnownStore head = make_store(2), knee = make_store(3);
  write_store("ct/head.isosplat", head);
  write_store("ct/2024/knee.isosplat", knee);
  write_store(".hidden/secret.isosplat", knee);
  std::filesystem::create_directory_symlink(folder.path() / "ct", folder.path() / "link");
  start();
  EXPECT_EQ(names(), (Names{"alpha", "ct~2024~knee", "ct~head"}));
  const std::string base = "/v1/volumes/ct~2024~knee/";
  EXPECT_EQ(list()["volumes"][1]["url"], "/v1/volumes/ct~2024~knee");
  EXPECT_EQ(get(port(), base + knee.content + "/file").body, text_of(knee.file));
  EXPECT_EQ(status(base + "bootstrap"), 200);
  EXPECT_EQ(status("/v1/volumes/ct%7E2024%7eknee"), 200) << "the same, escaped";
  EXPECT_EQ(status("/v1/volumes/ct/head"), 404);
  EXPECT_EQ(status("/v1/volumes/ct%2Fhead"), 400);
}

TEST_F(ManyStores, FoldersComeAndGo) {
  start();
  write_store("ct/a.isosplat", make_store(2));
  write_store("ct/deep/b.isosplat", make_store(3));
  EXPECT_TRUE(become({"alpha", "ct~a", "ct~deep~b"}));
  std::filesystem::rename(folder.path() / "ct", folder.path() / "mr");
  EXPECT_TRUE(become({"alpha", "mr~a", "mr~deep~b"}));
  write_store("mr/deep/c.isosplat", make_store(4));
  EXPECT_TRUE(become({"alpha", "mr~a", "mr~deep~b", "mr~deep~c"})) << "renamed, it is watched";
  std::filesystem::rename(folder.path() / "mr/deep/c.isosplat", folder.path() / "mr/d.isosplat");
  EXPECT_TRUE(become({"alpha", "mr~a", "mr~d", "mr~deep~b"}));
  {
    TemporaryFolder elsewhere;
    std::filesystem::rename(folder.path() / "mr/deep", elsewhere.path() / "deep");
    EXPECT_TRUE(become({"alpha", "mr~a", "mr~d"}));
    std::filesystem::rename(elsewhere.path() / "deep", folder.path() / "back");
    EXPECT_TRUE(become({"alpha", "back~b", "mr~a", "mr~d"}));
  }
  std::filesystem::remove_all(folder.path() / "mr");
  EXPECT_TRUE(become({"alpha", "back~b"}));
  EXPECT_EQ(status("/v1/volumes/mr~a"), 404);
}

TEST_F(ManyStores, ASourceWithinAnotherAddsNothing) {
  write_store("ct/head.isosplat", make_store(2));
  write_store("ct/old/knee.isosplat", make_store(3));
  options.stores = {folder.path().string() + "/", folder.path() / "ct", folder.path() / "ct/old"};
  start();
  EXPECT_EQ(names(), (Names{"alpha", "ct~head", "ct~old~knee"}));
  std::filesystem::rename(folder.path() / "ct", folder.path() / "away");
  EXPECT_TRUE(eventually([&] { return status("/v1/volumes/away~head") == 200; }));
  std::filesystem::rename(folder.path() / "away", folder.path() / "ct");
  write_store("ct/old/foot.isosplat", make_store(4));
  EXPECT_TRUE(become({"alpha", "ct~head", "ct~old~foot", "ct~old~knee"}));
}

TEST_F(ManyStores, AReplacedSourceFolderIsFound) {
  TemporaryFolder versions;
  for (const char* version : {"v1", "v2"}) {
    std::filesystem::create_directory(versions.path() / version);
    write_file(versions.path() / version / (version + std::string(".isosplat")), alpha.file);
  }
  std::filesystem::create_directory_symlink("v1", versions.path() / "current");
  options.stores = {versions.path() / "current"};
  start();
  EXPECT_EQ(names(), Names{"v1"});
  std::filesystem::create_directory_symlink("v2", versions.path() / "next");
  std::filesystem::rename(versions.path() / "next", versions.path() / "current");
  EXPECT_TRUE(become({"v2"}));
}

TEST_F(ManyStores, AFileThatIsBeingWrittenDoesNotAppear) {
  start();
  const KnownStore beta = make_store(2);
  const std::string text = text_of(beta.file);
  std::ofstream copy(folder.path() / "beta.isosplat", std::ios::binary);
  copy << text.substr(0, text.size() / 2) << std::flush;
  // A store that is added later is listed, so the server has seen the events of both.
  write_store("gamma.isosplat", make_store(3));
  EXPECT_TRUE(become({"alpha", "gamma"}));
  EXPECT_EQ(status("/v1/volumes/beta"), 404);
  copy << text.substr(text.size() / 2);
  copy.close();
  EXPECT_TRUE(become({"alpha", "beta", "gamma"}));
  EXPECT_EQ(get(port(), "/v1/volumes/beta/" + beta.content + "/file").body, text);
  EXPECT_FALSE(log_mentions("not served"));
}

TEST_F(ManyStores, ALinkToAStoreIsFollowed) {
  TemporaryFolder elsewhere;
  const KnownStore first = make_store(2), second = make_store(3);
  write_file(elsewhere.path() / "x.isosplat", first.file);
  start();
  std::filesystem::create_symlink(elsewhere.path() / "x.isosplat", folder.path() / "link.isosplat");
  EXPECT_TRUE(become({"alpha", "link"}));
  EXPECT_EQ(status("/v1/volumes/link/" + first.content + "/header"), 200);
  write_file(elsewhere.path() / "x.isosplat", second.file);  // not reported for the link
  EXPECT_TRUE(
      eventually([&] { return status("/v1/volumes/link/" + second.content + "/header") == 200; }));
  std::filesystem::remove(folder.path() / "link.isosplat");
  EXPECT_TRUE(become({"alpha"}));
}

TEST_F(ManyStores, TheListIsPagedAndSearched) {
  for (int i = 0; i < 5; ++i) {
    write_store("ct/b" + std::to_string(i) + ".isosplat",
                make_store(10 + static_cast<uint32_t>(i), {5, 5, 5}, 10));
  }
  write_store("Head.isosplat", make_store(1, {5, 5, 5}, 10, R"({"title":"Crâne de Jean"})"));
  write_file(folder.path() / "broken.isosplat", "no store");
  start();
  const Names all = {"Head", "alpha", "broken", "ct~b0", "ct~b1", "ct~b2", "ct~b3", "ct~b4"};
  struct Case {
    std::string query;
    size_t total;
    Names names;
  };
  for (const Case& each : std::vector<Case>{
           {"", 8, all},
           {"?query=", 8, all},
           {"?query=%20%20", 8, all},
           {"?limit=3", 8, {"Head", "alpha", "broken"}},
           {"?limit=3&offset=6", 8, {"ct~b3", "ct~b4"}},
           {"?offset=8", 8, {}},
           {"?offset=4294967295&limit=1000", 8, {}},
           {"?query=ct~", 5, {"ct~b0", "ct~b1", "ct~b2", "ct~b3", "ct~b4"}},
           {"?query=CT&limit=2&offset=1", 5, {"ct~b1", "ct~b2"}},
           {"?query=test%2012", 1, {"ct~b2"}},  // the title
           {"?query=12%20b2", 1, {"ct~b2"}},    // a word of each
           {"?query=Test%201", 6, {"alpha", "ct~b0", "ct~b1", "ct~b2", "ct~b3", "ct~b4"}},
           {"?query=cr%C3%A2ne", 1, {"Head"}},
           {"?query=JEAN%20head", 1, {"Head"}},
           {"?query=broken", 1, {"broken"}},
           {"?query=nothing", 0, {}},
           {"?query=%22%3Cscript%3E", 0, {}},
       }) {
    const Json found = list(each.query);
    EXPECT_EQ(names_of(found), each.names) << each.query;
    EXPECT_EQ(found["total"], each.total) << each.query;
    EXPECT_TRUE(found["offset"].is_number()) << each.query;
  }
  uint64_t bytes = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder.path())) {
    if (file.is_regular_file()) bytes += file.file_size();
  }
  EXPECT_EQ(list("?limit=1")["fileBytes"], bytes);
  EXPECT_NE(get(port(), "/v1/volumes?limit=1").header("etag"),
            get(port(), "/v1/volumes?limit=2").header("etag"));
  std::string many_words = "?query=a";
  for (int i = 0; i < 40; ++i) many_words += "%20a";
  for (const std::string& query :
       {std::string("?"), std::string("?limit=0"), std::string("?limit=1001"),
        std::string("?limit=-1"), std::string("?limit=x"), std::string("?limit="),
        std::string("?limit=1&limit=2"), std::string("?offset=01"),
        std::string("?offset=4294967296"), std::string("?offset=1.5"), std::string("?page=2"),
        std::string("?query=a&query=b"), std::string("?query=%zz"), std::string("?query=%00"),
        many_words}) {
    const Answer answer = get(port(), "/v1/volumes" + query);
    EXPECT_EQ(answer.status, 400) << query;
    EXPECT_NE(answer.body.find("invalid_argument"), std::string::npos) << answer.body;
  }
}

TEST_F(ManyStores, NothingOfAVolumeIsInTheListOfOthers) {
  const std::string ct_token = "0123456789abcdef-ct", name_token = "0123456789abcdef-names";
  write_store("ct/head.isosplat", make_store(2));
  write_store("ct/old/knee.isosplat", make_store(3));
  write_store("ctx/other.isosplat", make_store(4));
  TemporaryFolder secrets;
  write_file(secrets.path() / "tokens", ct_token + " " + (folder.path() / "ct").string() + "/\n" +
                                            name_token + " ct~old~* alpha\n");
  options.token_file = secrets.path() / "tokens";
  start();
  const std::string of_ct = "Authorization: Bearer " + ct_token + "\r\n";
  const std::string of_names = "Authorization: Bearer " + name_token + "\r\n";
  EXPECT_EQ(get(port(), "/v1/volumes").status, 401);
  EXPECT_EQ(get(port(), "/v1/volumes?query=head").status, 401);
  EXPECT_EQ(names("", of_ct), (Names{"ct~head", "ct~old~knee"}));
  EXPECT_EQ(names("", of_names), (Names{"alpha", "ct~old~knee"}));
  const Json part = list("?offset=1&limit=1", of_ct);
  EXPECT_EQ(names_of(part), Names{"ct~old~knee"});
  EXPECT_EQ(part["total"], 2);
  const Json other = list("?query=other", of_ct);
  EXPECT_EQ(other["total"], 0);
  EXPECT_EQ(other["fileBytes"], 0);
  EXPECT_EQ(list("?query=test%202", of_names)["total"], 0) << "the title of ct~head";
  EXPECT_EQ(get(port(), "/v1/volumes/ct~head", of_names).status, 404);
}

TEST_F(ManyStores, APoolKeepsTheLastUsedStoresOpen) {
  std::vector<KnownStore> stores;
  for (uint32_t i = 0; i < 8; ++i) {
    stores.push_back(make_store(20 + i, {40, 40, 40}, 500));
    write_store("s" + std::to_string(i) + ".isosplat", stores.back());
  }
  options.limits.open_stores = 3;
  start();
  const auto metric = [&](const std::string& name) {
    const std::string text = get(port(), "/metrics").body;
    const size_t at = text.find("\n" + name + " ");
    return at == std::string::npos ? -1.0 : std::stod(text.substr(at + name.size() + 2));
  };
  EXPECT_EQ(names().size(), 9u);
  EXPECT_EQ(metric("isosplat_stores_open"), 0) << "a list keeps none open";
  for (int round = 0; round < 3; ++round) {
    for (size_t i = 0; i < stores.size(); ++i) {
      const std::string base =
          "/v1/volumes/s" + std::to_string(i) + "/" + stores[i].content + "/chunks/";
      for (const KnownChunk& chunk : stores[i].chunks) {
        ASSERT_EQ(get(port(), base + place_of(chunk)).body, text_of(chunk.bytes));
      }
      EXPECT_LE(metric("isosplat_stores_open"), 3);
    }
  }
  EXPECT_EQ(metric("isosplat_stores_open"), 3);
  EXPECT_EQ(metric("isosplat_stores_opened_total"), 24) << "each once in each round";
  // If a closed store is replaced, its URLs change.
  write_store("s0.isosplat", make_store(99));
  const std::string old = "/v1/volumes/s0/" + stores[0].content + "/header";
  EXPECT_TRUE(eventually([&] { return status(old) == 404; }));
  EXPECT_EQ(status("/v1/volumes/s0"), 200);
  // A store that is removed or replaced is closed, so that its disk space becomes free.
  for (const char* name : {"s6", "s7"}) {
    std::filesystem::remove(folder.path() / (name + std::string(".isosplat")));
  }
  EXPECT_TRUE(eventually([&] { return metric("isosplat_stores_open") <= 1; }));
}

TEST_F(ManyStores, AResponseGoesOnWhenItsStoreIsReplacedOrRemoved) {
  options.limits.open_stores = 1;
  const KnownStore large = make_store(5, {200, 200, 130}, 300'000);
  write_store("large.isosplat", large);
  write_store("other.isosplat", make_store(6));
  start();
  for (const bool is_replaced : {true, false}) {
    const std::string current = is_replaced ? large.content : make_store(7).content;
    Client client(port());
    client.set_receive_buffer(256 * 1024);
    client.send("GET /v1/volumes/large/" + current + "/file HTTP/1.1\r\nHost: localhost\r\n\r\n");
    std::string received = client.read(1000);
    if (is_replaced) {
      write_store("large.isosplat", make_store(7));
    } else {
      std::filesystem::remove(folder.path() / "large.isosplat");
    }
    EXPECT_TRUE(
        eventually([&] { return status("/v1/volumes/large/" + current + "/header") == 404; }));
    EXPECT_EQ(status("/v1/volumes/other"), 200) << "the pool has room for one";
    const std::string file = text_of(is_replaced ? large.file : make_store(7).file);
    const size_t header = received.find("\r\n\r\n") + 4;
    received += client.read(header + file.size() - received.size());
    EXPECT_TRUE(received.substr(header) == file);
  }
}

TEST_F(ManyStores, ATruncatedStoreIsAnErrorWhileItIsServed) {
  options.scan_interval = std::chrono::hours(1);
  start();
  EXPECT_EQ(status(content("header")), 200);
  std::filesystem::resize_file(folder.path() / "alpha.isosplat", 1000);
  EXPECT_EQ(status(content("file")), 500);
  // The header in memory is still the one of the content id.
  const Answer header = get(port(), content("header"));
  EXPECT_TRUE(header.status == 500 ||
              header.body == text_of(alpha.file).substr(0, header.body.size()));
  write_file(folder.path() / "alpha.isosplat", alpha.file);
  EXPECT_TRUE(eventually([&] { return get(port(), content("file")).body == text_of(alpha.file); }));
}

TEST_F(ManyStores, ATruncatedStoreIsNoticed) {
  start();
  EXPECT_EQ(list()["volumes"][0].contains("contentId"), true);
  ASSERT_EQ(::truncate((folder.path() / "alpha.isosplat").c_str(), 1000), 0);
  EXPECT_TRUE(eventually([&] { return list()["volumes"][0].contains("error"); }));
  EXPECT_EQ(list()["volumes"][0]["error"]["status"], "truncated");
}

TEST_F(ManyStores, HealthAndListsCountOnlyReadableVolumes) {
  link_stores("many", 3000);
  std::string tokens = "0123456789abcdef-none nothing\n";
  for (int i = 0; i < 200; ++i) tokens += "anyone many~n0" + std::to_string(1000 + i) + "*\n";
  write_file(folder.path() / "tokens", tokens);
  options.token_file = folder.path() / "tokens";
  start();
  const Json health = Json::parse(get(port(), "/healthz").body);
  EXPECT_EQ(health["volumes"], 200);
  // The same holds for clients that may read no volume, and for the list.
  const std::string none = "Authorization: Bearer 0123456789abcdef-none\r\n";
  EXPECT_EQ(Json::parse(get(port(), "/healthz", none).body), health);
  EXPECT_EQ(list("?limit=2")["total"], 200);
  EXPECT_EQ(names("?limit=1"), Names{"many~n01000"});
  EXPECT_EQ(names("?query=n011&limit=1000").size(), 100u);
  EXPECT_EQ(status("/readyz"), 200);
  // The counts follow the changes.
  std::filesystem::remove(folder.path() / "many/n01000.isosplat");
  EXPECT_TRUE(
      eventually([&] { return Json::parse(get(port(), "/healthz").body)["volumes"] == 199; }));
  write_file(options.token_file, "anyone alpha\n");
  EXPECT_TRUE(server->reload());
  EXPECT_TRUE(
      eventually([&] { return Json::parse(get(port(), "/healthz").body)["volumes"] == 1; }));
  write_file(folder.path() / "alpha.isosplat", "no store");
  EXPECT_TRUE(eventually([&] { return Json::parse(get(port(), "/healthz").body)["broken"] == 1; }));
}

TEST_F(ManyStores, StoresAreClosedWhenDescriptorsRunOut) {
  link_stores("many", 100);
  start();
  Client client(port());
  EXPECT_EQ(client.request("GET", "/v1/volumes?limit=1000").status, 200);
  {
    const FewDescriptors few(12);
    for (const auto& volume : server->volumes()) {
      const Answer answer = client.request("GET", "/v1/volumes/" + volume.name + "/bootstrap");
      EXPECT_EQ(answer.status, 200) << volume.name << answer.body;
    }
  }
  {
    const FewDescriptors none(0);
    // The server closes every store before it gives up. Then it responds that it is busy, not that
    // the store is broken.
    const Answer answer = client.request("GET", "/v1/volumes/many~n00001/bootstrap");
    EXPECT_TRUE(answer.status == 200 || answer.status == 503) << answer.body;
  }
  EXPECT_EQ(client.request("GET", "/v1/volumes/many~n00001/bootstrap").status, 200);
  EXPECT_EQ(client.request("GET", "/readyz").status, 200);
  EXPECT_FALSE(log_mentions("not served"));
}

TEST_F(ManyStores, TenThousandStoresWithFewDescriptors) {
  for (int part = 0; part < 10; ++part) link_stores("part" + std::to_string(part), 1000);
  start();
  EXPECT_EQ(status("/readyz"), 200);
  Client client(port());
  auto few = std::make_unique<FewDescriptors>(16);
  const Json first = Json::parse(client.request("GET", "/v1/volumes").body);
  EXPECT_EQ(first["total"], 10'001);
  EXPECT_EQ(first["volumes"].size(), 100u);
  const Json found =
      Json::parse(client.request("GET", "/v1/volumes?query=part7%20n0042&limit=1000").body);
  EXPECT_EQ(found["total"], 10);
  EXPECT_EQ(names_of(found).front(), "part7~n00420");
  for (int i = 0; i < 10'000; i += 503) {
    std::string number = std::to_string(i % 1000);
    number.insert(0, 5 - number.size(), '0');
    const std::string name = "part" + std::to_string(i / 1000) + "~n" + number;
    EXPECT_EQ(client.request("GET", "/v1/volumes/" + name + "/" + alpha.content + "/header").status,
              200)
        << name;
  }
  few.reset();  // the test itself needs some
  std::filesystem::remove_all(folder.path() / "part3");
  EXPECT_TRUE(eventually([&] {
    return Json::parse(client.request("GET", "/v1/volumes?limit=1").body)["total"] == 9'001;
  }));
}

}  // namespace
}  // namespace isosplat::server::test
