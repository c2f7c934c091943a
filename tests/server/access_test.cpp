// Tokens, signed links and their cookies: who may read which volume. The response for a volume that
// a client may not read equals that for a volume that does not exist.

#include <gtest/gtest.h>

#include <ctime>
#include <nlohmann/json.hpp>

#include "server/access/access_rules.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;

const std::string kAlphaToken = "alpha-token-0123456789";
const std::string kAllToken = "all.token~0123+456/789==";
const std::string kFolderToken = "folder-token-0123456789";
const std::string kLinkKey = "0123456789abcdef0123456789abcdef";

class Access : public ServerTest {
 protected:
  Access() {
    std::filesystem::create_directories(folder.path() / "ct");
    for (const char* name : {"beta", "open", "ct/gamma"}) {
      write_file(folder.path() / (std::string(name) + ".isosplat"), beta.file);
    }
    write_file(page.path() / "index.html", std::string_view("<!doctype html><title>I</title>"));
    options.web_root = page.path();
    options.stores = {folder.path(), folder.path() / "ct"};
    options.token_file = secrets.path() / "tokens";
    write_tokens("# who may read\n\n" + kAlphaToken + " alpha\n" + kAllToken + "\t* \r\n" +
                 kFolderToken + " " + (folder.path() / "ct").string() + "/\nanyone op*\n");
  }

  void write_tokens(const std::string& text) { write_file(options.token_file, text); }

  static std::string bearer(const std::string& token) {
    return "Authorization: Bearer " + token + "\r\n";
  }

  std::string cookie(const std::string& value) const {
    return "Cookie: theme=dark; isosplat-" + std::to_string(port()) + "=" + value + "; x=y\r\n";
  }

  std::string link(const std::string& volume, int64_t seconds, const std::string& key = kLinkKey) {
    const std::string expires = std::to_string(std::time(nullptr) + seconds);
    return "exp=" + expires + "&sig=" + sign_link(key, ServedKind::volume, volume, expires);
  }

  std::vector<std::string> listed(const std::string& headers) const {
    std::vector<std::string> names;
    const Answer answer = get(port(), "/v1/volumes", headers);
    if (answer.status != 200) return {std::to_string(answer.status)};
    const Json list = Json::parse(answer.body);
    for (const Json& volume : list["volumes"]) names.push_back(volume["name"]);
    return names;
  }

  /// The whole response, except its time.
  static std::string without_date(Answer answer) {
    answer.headers.erase("date");
    std::string text = std::to_string(answer.status) + "\n";
    for (const auto& [name, value] : answer.headers) text += name + ": " + value + "\n";
    return text + answer.body;
  }

  const KnownStore beta = make_store(2);
  TemporaryFolder page, secrets;
};

using Names = std::vector<std::string>;

TEST_F(Access, TokensAdmitToTheirVolumes) {
  start();
  for (const auto& [headers, names] : std::vector<std::pair<std::string, Names>>{
           {"", {"open"}},
           {bearer(kAlphaToken), {"alpha", "open"}},
           {bearer(kAllToken), {"alpha", "beta", "ct~gamma", "open"}},
           {bearer(kFolderToken), {"ct~gamma", "open"}},
           {"Authorization: bearer   " + kAlphaToken + "\r\n", {"alpha", "open"}},
           {cookie(kAlphaToken), {"alpha", "open"}},
           {cookie(kAlphaToken) + bearer(kFolderToken), {"alpha", "ct~gamma", "open"}},
           {cookie("wrong") + bearer(kAlphaToken), {"alpha", "open"}},
           {bearer("wrong"), {"open"}},
           {bearer(kAlphaToken + "x"), {"open"}},
           {bearer(kAlphaToken.substr(1)), {"open"}},
           {bearer(""), {"open"}},
           {"Authorization: Basic " + kAllToken + "\r\n", {"open"}},
           {"Authorization: " + kAllToken + "\r\n", {"open"}},
           {"Cookie: isosplat=" + kAllToken + "\r\n", {"open"}},
           {"Cookie: isosplat-1=" + kAllToken + "\r\n", {"open"}}}) {
    EXPECT_EQ(listed(headers), names) << headers;
    const Json health = Json::parse(get(port(), "/healthz", headers).body);
    EXPECT_EQ(health["volumes"], 1) << "those that anyone may read: " << headers;
  }
}

TEST(AccessRules, PatternsStayWithinAFolder) {
  struct Case {
    std::string pattern;
    std::vector<std::string> admitted, refused;
  };
  for (const Case& each : std::vector<Case>{
           {"*", {"a", "ct~a", "ct~x~a"}, {}},
           {"demo-*", {"demo-a", "demo-"}, {"demo-internal~a", "demo-x~y~a", "demo", "x~demo-a"}},
           {"demo-?", {"demo-a"}, {"demo-~a", "demo-~", "demo-ab"}},
           {"ct?a", {"ct-a"}, {"ct~a"}},
           {"[!x]t[~]a", {}, {"ct~a"}},
           {"ct~*", {"ct~a", "ct~x~a"}, {"ct", "ctx~a", "x~ct~a"}},
           {"ct~x~*", {"ct~x~a", "ct~x~y~a"}, {"ct~a", "ct~y~a", "ct~xx~a"}},
           {"ct~a", {"ct~a"}, {"ct~a~b", "ct~ab", "a"}},
           {"ct~a*", {"ct~a", "ct~ab"}, {"ct~a~b", "ct~ab~a"}},
           {"*~*", {"ct~a", "ct~x~a"}, {"a"}},
           {"demo-*~*", {"demo-1~a", "demo-2~x~a"}, {"demo-a", "x~demo-1~a"}},
           {"*~a", {"ct~a"}, {"a", "ct~x~a"}}}) {
    auto rules = std::make_shared<AccessRules>();
    ASSERT_TRUE(rules->add_lines("anyone " + each.pattern + "\n"));
    const Grant grant = AccessRules::grant(rules, {}, 0);
    for (const std::string& name : each.admitted) {
      EXPECT_TRUE(grant.may_read(name, {{}, "/stores", "x.isosplat"}))
          << each.pattern << " " << name;
    }
    for (const std::string& name : each.refused) {
      EXPECT_FALSE(grant.may_read(name, {{}, "/stores", "x.isosplat"}))
          << each.pattern << " " << name;
    }
  }
}

TEST_F(Access, AVolumeWithoutPermissionIsNotFound) {
  start();
  const std::string content = beta.content;
  for (const std::string& headers :
       {std::string(), bearer(kAlphaToken), bearer("wrong-0123456789")}) {
    for (const std::string& rest :
         {std::string(), std::string("/bootstrap"), "/" + content + "/header",
          "/" + content + "/file", "/" + content + "/pages/0", "/" + content + "/chunks/0/0.0.0/0",
          "/" + content + "/chunks?isovalue=1&level=0", "/" + content + "/batch?chunks=0/0.0.0/0",
          "/" + content + "/nothing", std::string("/0123456789abcdef0123456789abcdef/file")}) {
      for (const char* method : {"GET", "HEAD", "OPTIONS"}) {
        const Answer existing = Client(port()).request(method, "/v1/volumes/beta" + rest, headers);
        const Answer missing = Client(port()).request(method, "/v1/volumes/none" + rest, headers);
        EXPECT_EQ(without_date(existing), without_date(missing)) << method << rest << headers;
        EXPECT_NE(existing.status, 200) << rest;
        EXPECT_EQ(existing.body.find(content), std::string::npos) << "nothing of the volume";
      }
    }
  }
  // Without a valid token, the response says that one is needed.
  const Answer unknown = get(port(), "/v1/volumes/beta");
  EXPECT_EQ(unknown.status, 401);
  EXPECT_EQ(unknown.header("www-authenticate"), "Bearer realm=\"isosplat\"");
  EXPECT_EQ(unknown.header("cache-control"), "no-store");
  EXPECT_EQ(Json::parse(unknown.body)["status"], "unauthorized");
  EXPECT_EQ(get(port(), "/v1/volumes/beta", bearer(kAlphaToken)).status, 404);
  // The page names only volumes that the client may read.
  EXPECT_EQ(get(port(), "/?volume=beta").header("link"), "");
  EXPECT_NE(get(port(), "/?volume=beta", bearer(kAllToken)).header("link"), "");
}

TEST_F(Access, SharedCachesMayStorePublicResponsesOnly) {
  start();
  const std::string own = "/v1/volumes/beta/" + beta.content;
  const std::string open = "/v1/volumes/open/" + beta.content;
  for (const char* rest : {"/header", "/file", "/chunks?isovalue=1&level=0"}) {
    EXPECT_EQ(get(port(), own + rest, bearer(kAllToken)).header("cache-control"),
              "private, max-age=31536000, immutable");
    EXPECT_EQ(get(port(), open + rest).header("cache-control"),
              "public, max-age=31536000, immutable");
  }
  EXPECT_EQ(get(port(), "/v1/volumes/beta", bearer(kAllToken)).header("cache-control"),
            "private, no-cache");
  EXPECT_EQ(get(port(), "/v1/volumes", bearer(kAllToken)).header("cache-control"),
            "private, no-cache");
  EXPECT_EQ(get(port(), "/").header("cache-control"), "private, no-cache");
  // A page of another origin requests permission to send the field.
  EXPECT_NE(Client(port())
                .request("OPTIONS", "/v1/volumes")
                .header("access-control-allow-headers")
                .find("Authorization"),
            std::string::npos);
}

TEST_F(Access, TheTokenOfAnAddressBecomesACookie) {
  start();
  const std::string name = "isosplat-" + std::to_string(port());
  const Answer moved =
      get(port(), "/?token=" + kAlphaToken + "&volume=alpha&view=1,2:3&t=a%20b%0d%22&empty");
  EXPECT_EQ(moved.status, 303);
  // Control characters cannot be decoded, so this item is dropped.
  EXPECT_EQ(moved.header("location"), "?volume=alpha&view=1,2:3&empty");
  EXPECT_EQ(moved.header("set-cookie"),
            name + "=" + kAlphaToken + "; Path=/; HttpOnly; SameSite=Strict");
  EXPECT_EQ(moved.header("cache-control"), "no-store");
  EXPECT_EQ(moved.header("referrer-policy"), "no-referrer");
  EXPECT_EQ(get(port(), "/?token=" + kAlphaToken).header("location"), "./");
  EXPECT_EQ(get(port(), "/?a%22=%26%3D&token=" + kAlphaToken).header("location"), "?a%22=%26%3D");
  const Answer wrong = get(port(), "/?token=wrong-0123456789&volume=alpha");
  EXPECT_EQ(wrong.status, 401);
  EXPECT_EQ(wrong.header("set-cookie"), "");
  // A valid cookie does not make another token valid.
  EXPECT_EQ(get(port(), "/?token=wrong-0123456789", cookie(kAlphaToken)).status, 401);
  // If there are several tokens, the first valid one becomes the cookie, and the address keeps
  // none.
  for (const std::string& query : {"token=" + kAlphaToken + "&token=" + kAllToken,
                                   "token=wrong-0123456789&x&t%6Fken=" + kAlphaToken,
                                   "token=&token=" + kAlphaToken + "&token=" + kAlphaToken}) {
    const Answer several = get(port(), "/?" + query);
    EXPECT_EQ(several.status, 303) << query;
    EXPECT_EQ(several.header("location").find("oken"), std::string::npos) << query;
    EXPECT_TRUE(several.header("set-cookie").starts_with(name + "=" + kAlphaToken + ";")) << query;
  }
  EXPECT_EQ(get(port(), "/?token=wrong-0123456789&token=wrong").status, 401);
  // Data requests accept no token in the address, since logs and caches keep addresses.
  EXPECT_EQ(get(port(), "/v1/volumes/alpha?token=" + kAlphaToken).status, 401);
}

TEST_F(Access, LinksAdmitToOneVolumeUntilTheyExpire) {
  options.link_key = kLinkKey;
  start();
  const std::string base = "/v1/volumes/beta";
  EXPECT_EQ(get(port(), base + "?" + link("beta", 100)).status, 200);
  EXPECT_EQ(get(port(), base + "/" + beta.content + "/file?" + link("beta", 100)).status, 200);
  EXPECT_EQ(
      get(port(), base + "/" + beta.content + "/chunks?isovalue=1&level=0&" + link("beta", 100))
          .status,
      200);
  const std::string valid = link("beta", 100);
  std::string changed = valid;
  changed.back() = changed.back() == '0' ? '1' : '0';
  std::string later = valid;
  later[4] = '9';  // the first digit of exp
  for (const std::string& query :
       {link("alpha", 100), link("beta", -1), link("beta", 100, kLinkKey + "x"), changed, later,
        valid.substr(0, valid.size() - 1), valid + "0", valid + "&" + valid,
        "exp=&sig=" + sign_link(kLinkKey, ServedKind::volume, "beta", ""),
        "exp=-1&sig=" + sign_link(kLinkKey, ServedKind::volume, "beta", "-1"),
        "exp=99999999999&sig=" + sign_link(kLinkKey, ServedKind::volume, "beta", "99999999999"),
        std::string("sig=x")}) {
    EXPECT_EQ(get(port(), base + "?" + query).status, 401) << query;
  }
  // A URL with an invalid link is refused: caches would keep another copy of the same content.
  const std::string open = "/v1/volumes/open/" + beta.content + "/header";
  EXPECT_EQ(get(port(), open + "?" + link("open", 100)).status, 200);
  EXPECT_EQ(get(port(), open + "?" + changed).status, 401);
  EXPECT_EQ(get(port(), open + "?exp=1").status, 400);
  // The page's requests have the link as a cookie.
  const Answer html = get(port(), "/?volume=beta&" + valid);
  EXPECT_EQ(html.status, 200);
  EXPECT_NE(html.header("link"), "");
  const std::string set = html.header("set-cookie");
  EXPECT_TRUE(set.ends_with("; Path=/; HttpOnly; SameSite=Strict")) << set;
  const std::string pair = "Cookie: " + set.substr(0, set.find(';')) + "\r\n";
  EXPECT_EQ(get(port(), base, pair).status, 200);
  EXPECT_EQ(listed(pair), (Names{"beta", "open"}));
  EXPECT_EQ(get(port(), "/v1/volumes/alpha", pair).status, 404);
  EXPECT_EQ(get(port(), "/?volume=beta&" + changed).header("set-cookie"), "");
}

TEST_F(Access, ReadsTokensAgain) {
  options.handle_signals = false;
  start();
  EXPECT_EQ(get(port(), "/v1/volumes/alpha", bearer(kAlphaToken)).status, 200);
  write_tokens(kAllToken + " *\n");
  EXPECT_TRUE(server->reload());
  EXPECT_EQ(get(port(), "/v1/volumes/alpha", bearer(kAlphaToken)).status, 401);
  EXPECT_EQ(get(port(), "/v1/volumes/alpha", bearer(kAllToken)).status, 200);
  // A file with an error changes nothing, and the message contains no token.
  write_tokens("short *\n");
  const Result<void> reloaded = server->reload();
  ASSERT_FALSE(reloaded);
  EXPECT_EQ(reloaded.error().message.find("short "), std::string::npos);
  EXPECT_TRUE(will_log("the old ones stay"));
  EXPECT_EQ(get(port(), "/v1/volumes/alpha", bearer(kAllToken)).status, 200);
  // An empty file admits nobody.
  write_tokens("");
  EXPECT_TRUE(server->reload());
  EXPECT_EQ(get(port(), "/v1/volumes/open", bearer(kAllToken)).status, 401);
  EXPECT_EQ(listed(bearer(kAllToken)), Names{"401"});
}

TEST_F(Access, InvalidTokenFilesAreRefused) {
  for (const std::string& text :
       {std::string("short *\n"), kAllToken + "\n", std::string("anyone\n"),
        std::string("with-umlaut-\xc3\xa4-0123456789 *\n"),
        std::string("quote\"-0123456789abcdef *\n")}) {
    write_tokens(text);
    const auto started = Server::start(options);
    ASSERT_FALSE(started) << text;
    EXPECT_EQ(started.error().status, Status::invalid_argument);
    EXPECT_NE(started.error().message.find("line 1"), std::string::npos);
    EXPECT_EQ(started.error().message.find("0123456789"), std::string::npos);
  }
  options.token_file = secrets.path() / "none";
  EXPECT_EQ(Server::start(options).error().status, Status::io_error);
  options.token_file.clear();
  options.link_key = "short";
  EXPECT_EQ(Server::start(options).error().status, Status::invalid_argument);
}

TEST_F(Access, TheLogHasNoSecrets) {
  std::mutex mutex;
  std::string log;
  options.link_key = kLinkKey;
  options.access_log = [&](std::string_view line) {
    const std::lock_guard lock(mutex);
    (log += line) += '\n';
  };
  start();
  const std::string valid = link("beta", 100);
  get(port(), "/?token=" + kAlphaToken + "&volume=alpha");
  get(port(), "/?t%6Fken=" + kAlphaToken);
  get(port(), "/v1/volumes/beta?" + valid);
  get(port(), "/v1/volumes", bearer(kAlphaToken) + cookie(kAlphaToken));
  server.reset();
  const std::lock_guard lock(mutex);
  EXPECT_EQ(log.find(kAlphaToken), std::string::npos) << log;
  EXPECT_EQ(log.find(valid.substr(valid.find("sig="))), std::string::npos) << log;
  EXPECT_NE(log.find("/?token=*&volume=alpha"), std::string::npos) << log;
}

TEST_F(Access, SignaturesAreHmacSha256) {
  // printf 'isosplat link 1\nengine\n1700000000' | openssl dgst -sha256 -hmac KEY
  EXPECT_EQ(sign_link(kLinkKey, ServedKind::volume, "engine", "1700000000").size(), 64u);
  EXPECT_EQ(sign_link(kLinkKey, ServedKind::volume, "engine", "1700000000"),
            "bc65b6a751eca2fb21eb8e9899eba36782655ad205e869067df774a6acfa2725");
  const Result<std::string> one = random_token(), other = random_token();
  ASSERT_TRUE(one && other);
  EXPECT_EQ(one->size(), 64u);
  EXPECT_NE(*one, *other);
}

}  // namespace
}  // namespace isosplat::server::test
