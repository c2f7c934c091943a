// Scenes over a real socket: lists, bootstraps, ranges, names, access, and files that change while
// they are served.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "server/access/access_rules.h"
#include "shared/core/scene/bundle_header.h"
#include "shared/system/scene_file/bundle_bytes.h"
#include "tests/server/server_fixture.h"
#include "tests/server/unzipped.h"

namespace isosplat::server::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Beside the store alpha, there is the folder run with a scene of two stores, and the same scene
/// as a bundle.
class SceneRoutes : public ServerTest {
 protected:
  SceneRoutes() {
    fs::create_directories(folder.path() / "run/deep");
    write_file(folder.path() / "run/one.isosplat", one.file);
    write_file(folder.path() / "run/deep/two.isosplat", two.file);
    write("run/scene.json", document({"one.isosplat", "deep/two.isosplat"}));
    write_file(folder.path() / "run.isobundle", bundle_of("run/scene.json"));
  }

  void write(const std::string& path, const std::string& text) const {
    write_file(folder.path() / path, text);
  }

  static std::string document(const std::vector<std::string>& stores) {
    Json json = {{"format", "isosplat-scene"}, {"version", 1}, {"name", "Two Volumes"}};
    for (const std::string& store : stores) json["layers"].push_back({{"store", store}});
    return json.dump();
  }

  /// A scene of one layer, with one store for each step of time.
  static std::string series(const std::vector<std::string>& stores) {
    Json json = {{"format", "isosplat-scene"}, {"version", 1}};
    json["layers"] = {{{"stores", stores}}};
    for (size_t i = 0; i < stores.size(); ++i) json["time"]["steps"].push_back(i);
    return json.dump();
  }

  /// The bytes of the bundle of a scene.
  std::vector<std::byte> bundle_of(const std::string& path) const {
    const auto scene = SceneFile::open(folder.path() / path);
    EXPECT_TRUE(scene) << scene.error().message;
    const auto plan = BundleBytes::plan(*scene);
    EXPECT_TRUE(plan) << plan.error().message;
    std::vector<std::byte> bytes(plan->bytes());
    EXPECT_TRUE(plan->read(0, bytes));
    return bytes;
  }

  Json json(const std::string& target) const {
    const Answer answer = get(port(), target);
    EXPECT_EQ(answer.status, 200) << target << answer.body;
    return Json::parse(answer.body);
  }

  std::string content_of(const std::string& name) const {
    return json("/v1/scenes/" + name)["contentId"];
  }

  std::string file_of(const std::string& name) const {
    return "/v1/scenes/" + name + "/" + content_of(name) + "/file";
  }

  int status(const std::string& target, const std::string& headers = {}) const {
    return get(port(), target, headers).status;
  }

  const KnownStore one = make_store(11, {60, 50, 40}), two = make_store(12, {40, 30, 20});
};

TEST_F(SceneRoutes, AreListedBesideVolumes) {
  start();
  const Json scenes = json("/v1/scenes");
  EXPECT_EQ(scenes["total"], 2);
  ASSERT_EQ(scenes["scenes"].size(), 2u);
  const Json& bundle = scenes["scenes"][0];
  EXPECT_EQ(bundle["name"], "run");
  EXPECT_EQ(bundle["title"], "Two Volumes");
  EXPECT_EQ(bundle["layers"], 2);
  EXPECT_FALSE(bundle.contains("steps"));
  EXPECT_EQ(bundle["fileBytes"], fs::file_size(folder.path() / "run.isobundle"));
  const Json& beside = scenes["scenes"][1];
  EXPECT_EQ(beside["name"], "run~scene");
  // Both are the same scene, so both have its content and size.
  EXPECT_EQ(beside["contentId"], bundle["contentId"]);
  EXPECT_EQ(beside["fileBytes"], bundle["fileBytes"]);
  EXPECT_EQ(json("/v1/scenes?query=two%20RUN")["total"], 2);
  EXPECT_EQ(json("/v1/scenes?query=three")["total"], 0);
  EXPECT_EQ(json("/v1/scenes?offset=1&limit=1")["scenes"][0]["name"], "run~scene");
  EXPECT_EQ(status("/v1/scenes?limit=0"), 400);
  EXPECT_EQ(status("/v1/scenes?other=1"), 400);
  const Json volumes = json("/v1/volumes");
  EXPECT_EQ(volumes["total"], 3);
  Json one_scene = json("/v1/scenes/run");
  EXPECT_EQ(one_scene["urls"]["bootstrap"], "/v1/scenes/run/bootstrap");
  one_scene.erase("urls");
  EXPECT_EQ(one_scene, bundle);
}

TEST_F(SceneRoutes, ASceneBesideItsStoresHasTheBytesOfItsBundle) {
  start();
  const std::vector<std::byte> bytes = bundle_of("run/scene.json");
  const std::string expected = text_of(bytes);
  for (const std::string& name : std::vector<std::string>{"run", "run~scene"}) {
    const std::string file = file_of(name);
    const Answer whole = get(port(), file);
    EXPECT_EQ(whole.status, 200);
    EXPECT_TRUE(whole.body == expected) << name;
    EXPECT_EQ(whole.header("accept-ranges"), "bytes");
    EXPECT_EQ(whole.header("cache-control"), "public, max-age=31536000, immutable");
    const std::string etag = whole.header("etag");
    EXPECT_EQ(etag, "\"" + content_of(name) + "\"");
    for (const auto& [first, last] : std::vector<std::pair<size_t, size_t>>{
             {0, 0}, {5, 99}, {20'000, 30'000}, {expected.size() - 3, expected.size() - 1}}) {
      const Answer part =
          get(port(), file,
              "Range: bytes=" + std::to_string(first) + "-" + std::to_string(last) + "\r\n");
      EXPECT_EQ(part.status, 206);
      EXPECT_TRUE(part.body == expected.substr(first, last - first + 1)) << first;
      EXPECT_EQ(part.header("content-range"), "bytes " + std::to_string(first) + "-" +
                                                  std::to_string(last) + "/" +
                                                  std::to_string(expected.size()));
    }
    const std::string beyond = "Range: bytes=" + std::to_string(expected.size()) + "-\r\n";
    EXPECT_EQ(status(file, beyond), 416);
    EXPECT_EQ(get(port(), file, beyond).header("content-range"),
              "bytes */" + std::to_string(expected.size()));
    EXPECT_EQ(status(file, "If-None-Match: " + etag + "\r\n"), 304);
    EXPECT_EQ(status(file, "If-Match: \"other\"\r\n"), 412);
    EXPECT_EQ(status(file, "Range: bytes=0-1\r\nIf-Range: \"other\"\r\n"), 200);
    EXPECT_EQ(status(file, "Range: bytes=0-1\r\nIf-Range: " + etag + "\r\n"), 206);
    Client client(port());
    client.send("HEAD " + file + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    const Answer head = client.receive(true);
    EXPECT_EQ(head.status, 200);
    EXPECT_EQ(head.header("content-length"), std::to_string(expected.size()));
    EXPECT_EQ(client.request("OPTIONS", file).status, 204);
    EXPECT_EQ(client.request("POST", file).status, 405);
  }
}

TEST_F(SceneRoutes, TheBootstrapIsTheBeginningOfTheBundle) {
  write("hidden.scene.json",
        R"({"format":"isosplat-scene","version":1,"layers":[{"store":"run/one.isosplat"},)"
        R"({"store":"run/deep/two.isosplat","visible":false}]})");
  write("run/series.scene.json", series({"one.isosplat", "deep/two.isosplat"}));
  start();
  for (const std::string& name :
       std::vector<std::string>{"run", "run~scene", "hidden.scene", "run~series.scene"}) {
    const std::string whole = get(port(), file_of(name)).body;
    const Answer bootstrap = get(port(), "/v1/scenes/" + name + "/bootstrap");
    EXPECT_EQ(bootstrap.status, 200);
    EXPECT_EQ(bootstrap.header("cache-control"), "no-cache");
    ASSERT_TRUE(whole.starts_with(bootstrap.body)) << name;
    const auto bytes = std::as_bytes(std::span(whole));
    const auto size = bundle_header_bytes(bytes.first(kBundlePrefixBytes));
    ASSERT_TRUE(size);
    const auto header = parse_bundle_header(bytes.first(*size));
    ASSERT_TRUE(header) << header.error().message;
    // In run, both stores are visible at first; in the other scenes, only the first one.
    const uint64_t coarse = name.starts_with("run") && name.find("series") == std::string::npos
                                ? header->coarse_bytes
                                : header->stores[0].coarse_bytes();
    EXPECT_EQ(bootstrap.body.size(), *size + coarse) << name;
    EXPECT_EQ(status("/v1/scenes/" + name + "/bootstrap",
                     "If-None-Match: " + bootstrap.header("etag") + "\r\n"),
              304);
  }
  EXPECT_EQ(json("/v1/scenes/run~series.scene")["steps"], 2);
}

/// The headers of many small stores are mostly zeros.
TEST_F(SceneRoutes, TheFirstPartIsCompressedForClientsThatAdmitIt) {
  start();
  for (const std::string& path : std::vector<std::string>{"run", "run~scene"}) {
    const std::string target = "/v1/scenes/" + path + "/bootstrap";
    const Answer plain = get(port(), target);
    EXPECT_EQ(plain.header("content-encoding"), "");
    EXPECT_EQ(plain.header("vary"), "Accept-Encoding");
    for (int i = 0; i < 2; ++i) {  // compressed, then cached
      const Answer small = get(port(), target, "Accept-Encoding: gzip\r\n");
      ASSERT_EQ(small.status, 200);
      EXPECT_EQ(small.header("content-encoding"), "gzip");
      EXPECT_EQ(small.header("content-type"), "application/octet-stream");
      EXPECT_EQ(small.header("cache-control"), plain.header("cache-control"));
      EXPECT_NE(small.header("etag"), plain.header("etag"));
      EXPECT_LT(small.body.size(), plain.body.size());
      EXPECT_TRUE(unzipped(small.body) == plain.body);
      EXPECT_EQ(status(target,
                       "Accept-Encoding: gzip\r\nIf-None-Match: " + small.header("etag") + "\r\n"),
                304);
    }
  }
}

/// Every path has another name, so that no link or token for a name opens another scene.
TEST_F(SceneRoutes, NamesDependOnPathsAlone) {
  const std::vector<std::byte> bundle = bundle_of("run/scene.json");
  for (const char* file : {"scene.isobundle", "x.scene.isobundle", "x.isobundle", "a b.isobundle",
                           "scene.isobundle.isobundle", ".hidden.isobundle"}) {
    write_file(folder.path() / file, bundle);
  }
  write("x.scene.json", document({"run/one.isosplat"}));
  write("scene.json", document({"run/one.isosplat"}));
  write("notes.json", "{}");
  start();
  std::set<std::string> names;
  const Json scenes = json("/v1/scenes");
  for (const Json& each : scenes["scenes"]) {
    names.insert(each["name"]);
    EXPECT_FALSE(each.contains("error")) << each;
  }
  EXPECT_EQ(names.size(), 9u) << scenes.dump(1);
  for (const char* name : {"x", "x.scene", "scene", "run", "run~scene", "scene.isobundle"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
  EXPECT_EQ(json("/v1/scenes/scene")["layers"], 1);
  EXPECT_EQ(json("/v1/scenes/x.scene")["layers"], 1);
}

TEST_F(SceneRoutes, HostileNamesAndPathsAreRefused) {
  start();
  const std::string content = content_of("run");
  for (const std::string& target : std::vector<std::string>{
           "/v1/scenes/alpha", "/v1/scenes/none", "/v1/scenes/run.isobundle", "/v1/scenes/RUN",
           "/v1/scenes/run/0123456789abcdef/file", "/v1/scenes/run/bootstrap/file",
           "/v1/scenes/scene%20run", "/v1/scenes/run/file", "/v1/volumes/run~scene",
           "/v1/scenes/run~one"}) {
    EXPECT_EQ(status(target), 404) << target;
  }
  EXPECT_EQ(status("/v1/volumes/run"), 404);
  EXPECT_EQ(status("/v1/scenes/run/" + alpha.content + "/file"), 404);
  EXPECT_EQ(status("/v1/scenes/run/" + content + "/chunks?isovalue=1&level=0"), 404);
  EXPECT_EQ(status("/v1/scenes/run/" + content + "/thumbnail.webp"), 404);
  for (const std::string& target :
       std::vector<std::string>{"/v1/scenes/..%2Falpha", "/v1/scenes/run/../alpha",
                                "/v1/scenes/%2e%2e", "/v1/scenes/a%00"}) {
    EXPECT_EQ(status(target), 400) << target;
  }
  EXPECT_EQ(status("/v1/scenes/run/" + content + "/file?x=1"), 400);
}

/// The stores of a document must be below its folder; with refused links, below the source.
TEST_F(SceneRoutes, ADocumentCannotNameFilesElsewhere) {
  TemporaryFolder other;
  write_file(other.path() / "secret.isosplat", one.file);
  fs::create_symlink(other.path() / "secret.isosplat", folder.path() / "run/link.isosplat");
  fs::create_symlink(other.path(), folder.path() / "run/away");
  write("run/up.scene.json", document({"../alpha.isosplat"}));
  write("run/absolute.scene.json", document({(other.path() / "secret.isosplat").string()}));
  write("run/address.scene.json", document({"https://a.example/x.isosplat"}));
  write("run/link.scene.json", document({"link.isosplat"}));
  write("run/away.scene.json", document({"away/secret.isosplat"}));
  write("run/none.scene.json", document({"none.isosplat"}));
  write("run/text.scene.json", "{");
  write("damaged.isobundle", "ISOBNDL");
  options.follow_outside_links = false;
  start();
  for (const std::string& name : std::vector<std::string>{
           "run~up.scene", "run~absolute.scene", "run~address.scene", "run~link.scene",
           "run~away.scene", "run~none.scene", "run~text.scene", "damaged"}) {
    const Answer answer = get(port(), "/v1/scenes/" + name + "/bootstrap");
    EXPECT_EQ(answer.status, 500) << name;
    EXPECT_EQ(answer.body.find(folder.path().string()), std::string::npos) << answer.body;
    EXPECT_TRUE(will_log("scene " + name + " is not served: ")) << name;
  }
  // The others are served, and the list names the errors.
  EXPECT_EQ(status("/v1/scenes/run/bootstrap"), 200);
  size_t broken = 0;
  const Json scenes = json("/v1/scenes");
  for (const Json& each : scenes["scenes"]) broken += each.contains("error");
  EXPECT_EQ(broken, 8u);
  EXPECT_TRUE(eventually([&] {
    return get(port(), "/metrics").body.find("isosplat_scenes{state=\"broken\"} 8") !=
           std::string::npos;
  }));
}

TEST_F(SceneRoutes, LinksOutOfTheFolderAreFollowedByDefault) {
  TemporaryFolder other;
  write_file(other.path() / "far.isosplat", one.file);
  fs::create_symlink(other.path() / "far.isosplat", folder.path() / "run/link.isosplat");
  write("run/link.scene.json", document({"link.isosplat"}));
  start();
  EXPECT_EQ(status("/v1/scenes/run~link.scene/bootstrap"), 200);
}

// ---- Changes while served ----

TEST_F(SceneRoutes, AReplacedBundleHasAnotherContent) {
  start();
  const std::string before = file_of("run");
  EXPECT_EQ(status(before), 200);
  write("other.scene.json", document({"run/one.isosplat"}));
  write_file(folder.path() / "run.isobundle", bundle_of("other.scene.json"));
  ASSERT_TRUE(eventually([&] { return file_of("run") != before; }));
  const Answer old = get(port(), before);
  EXPECT_EQ(old.status, 404);
  EXPECT_NE(old.body.find("the content of this scene is now " + content_of("run")),
            std::string::npos)
      << old.body;
  EXPECT_EQ(status(file_of("run")), 200);
  EXPECT_TRUE(will_log("scene run: "));
  fs::remove(folder.path() / "run.isobundle");
  EXPECT_TRUE(eventually([&] { return status("/v1/scenes/run") == 404; }));
  EXPECT_TRUE(will_log("scene run was removed"));
}

TEST_F(SceneRoutes, AStoreThatIsReplacedBesideItsSceneIsNoticed) {
  start();
  const std::string before = file_of("run~scene");
  EXPECT_EQ(status(before), 200);
  write_file(folder.path() / "run/deep/two.isosplat", make_store(13, {44, 30, 20}).file);
  ASSERT_TRUE(eventually([&] { return file_of("run~scene") != before; }));
  EXPECT_EQ(status(before), 404);
  const std::string whole = get(port(), file_of("run~scene")).body;
  EXPECT_TRUE(whole == text_of(bundle_of("run/scene.json")));
  // A store that disappears, and comes back.
  fs::rename(folder.path() / "run/one.isosplat", folder.path() / "gone");
  EXPECT_TRUE(eventually([&] { return status("/v1/scenes/run~scene") == 500; }));
  fs::rename(folder.path() / "gone", folder.path() / "run/one.isosplat");
  EXPECT_TRUE(eventually([&] { return status("/v1/scenes/run~scene") == 200; }));
}

/// As `isosplat build -o run/` appends: first the store, then the document.
TEST_F(SceneRoutes, AppendedStepsAreServed) {
  write("run/series.scene.json", series({"one.isosplat"}));
  start();
  const std::string before = file_of("run~series.scene");
  EXPECT_EQ(json("/v1/scenes/run~series.scene")["steps"], 1);
  const std::string bytes = get(port(), before).body;
  for (int i = 0; i < 20; ++i) {
    const std::string store = "step" + std::to_string(i) + ".isosplat";
    write_file(folder.path() / "run" / store, make_store(20 + i, {40, 30, 20}).file);
    EXPECT_TRUE(get(port(), before).body == bytes);  // a new store alone changes nothing
  }
  write("run/series.scene.json", series({"one.isosplat", "step0.isosplat", "step19.isosplat"}));
  ASSERT_TRUE(eventually([&] { return json("/v1/scenes/run~series.scene")["steps"] == 3; }));
  EXPECT_EQ(status(before), 404);
  EXPECT_TRUE(get(port(), file_of("run~series.scene")).body ==
              text_of(bundle_of("run/series.scene.json")));
}

/// A response never mixes the bytes of two contents: it ends early instead. The response of a
/// bundle, which stays open, is completed from the file with which it began.
TEST_F(SceneRoutes, AResponseEndsEarlyIfAStoreIsReplacedMeanwhile) {
  const KnownStore large = make_store(31, {800, 600, 400}, 60'000);
  ASSERT_GT(large.file.size(), size_t{16} << 20);
  fs::create_directories(folder.path() / "large");
  write_file(folder.path() / "large/a.isosplat", large.file);
  write("large/scene.json", document({"a.isosplat"}));
  const std::vector<std::byte> bundle = bundle_of("large/scene.json");
  write_file(folder.path() / "large.isobundle", bundle);
  options.limits.write_time = std::chrono::minutes(2);
  start();
  const std::string targets[] = {file_of("large~scene"), file_of("large")};
  std::vector<Client> clients;
  for (const std::string& target : targets) {
    Client client(port());
    client.set_receive_buffer(16 * 1024);
    client.send("GET " + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_TRUE(client.read(1000).starts_with("HTTP/1.1 200")) << target;
    clients.push_back(std::move(client));
  }
  write_file(folder.path() / "large/a.isosplat", make_store(32, {60, 50, 40}).file);
  write_file(folder.path() / "large.isobundle", bundle_of("run/scene.json"));
  const size_t beside = clients[0].read(bundle.size() + 10'000).size();
  EXPECT_LT(beside, bundle.size());
  const size_t whole = clients[1].read(bundle.size() - 900).size();
  EXPECT_EQ(whole, bundle.size() - 900);
}

// ---- Access ----

class SceneAccess : public SceneRoutes {
 protected:
  static constexpr const char* kKey = "0123456789abcdef0123456789abcdef";
  static constexpr const char* kLater = "4000000000";

  static std::string link(ServedKind kind, const std::string& name) {
    return std::string("exp=") + kLater + "&sig=" + sign_link(kKey, kind, name, kLater);
  }

  void use_tokens(const std::string& lines) {
    write_file(folder.path() / ".tokens", lines);
    options.token_file = folder.path() / ".tokens";
  }

  static std::string bearer(const std::string& token) {
    return "Authorization: Bearer " + token + "\r\n";
  }
};

TEST_F(SceneAccess, ALinkOpensOneKindOnly) {
  write_file(folder.path() / "run.isosplat", one.file);  // a volume with the name of the scene
  options.link_key = kKey;
  start();
  const std::string scene = link(ServedKind::scene, "run"),
                    volume = link(ServedKind::volume, "run");
  EXPECT_EQ(status("/v1/scenes/run?" + scene), 200);
  EXPECT_EQ(status("/v1/scenes/run/bootstrap?" + scene), 200);
  EXPECT_EQ(status("/v1/volumes/run?" + volume), 200);
  for (const std::string& target : std::vector<std::string>{
           "/v1/scenes/run?" + volume, "/v1/volumes/run?" + scene, "/v1/scenes/run~scene?" + scene,
           "/v1/volumes/run~one?" + scene, "/v1/volumes/scene%20run?" + scene, "/v1/scenes/run",
           "/v1/scenes"}) {
    EXPECT_EQ(status(target), 401) << target;
  }
  // The page's cookie has the kind, too.
  const Answer page = get(port(), "/?scene=run&" + scene);
  const std::string cookie =
      page.header("set-cookie").substr(0, page.header("set-cookie").find(';'));
  EXPECT_NE(cookie.find("-scene-run="), std::string::npos) << cookie;
  EXPECT_EQ(status("/v1/scenes/run/bootstrap", "Cookie: " + cookie + "\r\n"), 200);
  EXPECT_EQ(status("/v1/volumes/run", "Cookie: " + cookie + "\r\n"), 404);
  EXPECT_EQ(get(port(), "/?volume=run&" + scene).header("set-cookie"), "");
  EXPECT_EQ(get(port(), "/?scene=run&" + volume).header("set-cookie"), "");
  std::string forged = cookie;
  forged.replace(forged.find("-scene-"), 7, "-link-");
  EXPECT_EQ(status("/v1/volumes/run", "Cookie: " + forged + "\r\n"), 401);
  // A client with the link finds only this scene in the list.
  const Answer list = get(port(), "/v1/scenes", "Cookie: " + cookie + "\r\n");
  EXPECT_EQ(Json::parse(list.body)["total"], 1);
  EXPECT_EQ(Json::parse(get(port(), "/v1/volumes", "Cookie: " + cookie + "\r\n").body)["total"], 0);
}

TEST_F(SceneAccess, PatternsMeanVolumesUnlessTheySayScenes) {
  write_file(folder.path() / "run.isosplat", one.file);
  const std::string run = (folder.path() / "run").string();
  use_tokens(
      "token-of-a-volume run\ntoken-of-a-scene-- scene:run\ntoken-of-wildcard r*\n"
      "token-of-all-----  *\ntoken-of-scenes-- scene:*\ntoken-of-below--- run~*\n"
      "token-of-folder-- " +
      run + "/\ntoken-of-file---- " + run +
      ".isobundle\n"
      "token-of-beside-- scene:run~sc*\n");
  start();
  const auto opened = [&](const std::string& token) {
    std::string result;
    for (const std::string& target : std::vector<std::string>{
             "/v1/volumes/run", "/v1/scenes/run", "/v1/scenes/run~scene", "/v1/volumes/run~one"}) {
      const int got = status(target, bearer(token));
      EXPECT_TRUE(got == 200 || got == 404) << target << got;
      result += got == 200 ? 'x' : '-';
    }
    return result;
  };
  EXPECT_EQ(opened("token-of-a-volume"), "x---");
  EXPECT_EQ(opened("token-of-a-scene--"), "-x--");
  EXPECT_EQ(opened("token-of-wildcard"), "x---");
  EXPECT_EQ(opened("token-of-all-----"), "xxxx");
  EXPECT_EQ(opened("token-of-scenes--"), "-xx-");
  EXPECT_EQ(opened("token-of-below---"), "--xx");
  EXPECT_EQ(opened("token-of-folder--"), "--xx");
  EXPECT_EQ(opened("token-of-file----"), "-x--");
  EXPECT_EQ(opened("token-of-beside--"), "--x-");
  EXPECT_EQ(status("/v1/scenes/run"), 401);
  // Scenes that everyone may read are public to caches, others are not.
  EXPECT_EQ(
      get(port(), "/v1/scenes/run/bootstrap", bearer("token-of-all-----")).header("cache-control"),
      "private, no-cache");
  EXPECT_EQ(status("/metrics", bearer("token-of-scenes--") + "Via: 1.1 x\r\n"), 401);
}

TEST_F(SceneRoutes, AFileIsASource) {
  options.stores = {folder.path() / "run/scene.json", folder.path() / "run.isobundle"};
  start();
  const Json scenes = json("/v1/scenes");
  ASSERT_EQ(scenes["total"], 2);
  EXPECT_EQ(scenes["scenes"][0]["name"], "run");
  EXPECT_EQ(scenes["scenes"][1]["name"], "scene");
  EXPECT_EQ(json("/v1/volumes")["total"], 0);
  const std::string before = file_of("scene");
  write_file(folder.path() / "run/one.isosplat", make_store(14, {44, 30, 20}).file);
  EXPECT_TRUE(eventually([&] { return file_of("scene") != before; }));
}

TEST_F(SceneRoutes, ThePagePreloadsTheScene) {
  options.web_root = folder.path() / ".web";
  fs::create_directories(options.web_root);
  write_file(options.web_root / "index.html", std::string_view("<!doctype html>"));
  start();
  EXPECT_EQ(get(port(), "/?scene=run").header("link"),
            "<v1/scenes/run/bootstrap>; rel=preload; as=fetch; crossorigin=anonymous");
  EXPECT_EQ(get(port(), "/?scene=alpha").header("link"), "");
  EXPECT_EQ(get(port(), "/?volume=run").header("link"), "");
}

}  // namespace
}  // namespace isosplat::server::test
