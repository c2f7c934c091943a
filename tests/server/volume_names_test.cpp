// Rights never apply to another store, because the name of a volume depends only on the path of its
// store.

#include "server/catalog/volume_names.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>
#include <set>

#include "server/access/access_rules.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;
using Names = std::vector<std::string>;

TEST(NameSegments, DifferentTextsHaveDifferentOnes) {
  for (const char* const plain : {"ct", "Scans_2.1", "a--b", "0", "scan-20240101", "a-1234abcd"}) {
    EXPECT_EQ(name_segment(plain), plain);
  }
  const std::string longest(128, 'a');
  EXPECT_EQ(name_segment(longest), longest);
  Names texts = {"张三",  "李四",        "Müller",      "Möller",       "ct ",  "ct",
                 "-ct",   "ct-",         "a~b",         "a-b",          "a b",  "volume",
                 longest, longest + 'a', longest + 'b', longest + "/b", "\xff", "\xfe",
                 "",      ".",           "..",          "a\nb",         "A b"};
  for (size_t i = 0; i < 20; ++i) texts.push_back(name_segment(texts[i]) + "--0123abcd");
  for (const char* const other : {"张三", "a b", "ct-"}) texts.push_back(name_segment(other));
  std::set<std::string> names;
  for (const std::string& text : texts) {
    const std::string name = name_segment(text);
    EXPECT_TRUE(names.insert(name).second) << text;
    EXPECT_LE(name.size(), 128u);
    EXPECT_TRUE(is_volume_name(name)) << name;
  }
  EXPECT_TRUE(name_segment("Müller").starts_with("M-ller--"));
  EXPECT_TRUE(name_segment("My Scan (2)").starts_with("My-Scan-2--"));
  EXPECT_EQ(name_segment("Müller"), name_segment("Müller")) << "always the same";
}

TEST(VolumeName, IsDistinguishedFromOtherTexts) {
  for (const char* name : {"a", "ct~a", "ct~2024~a.b_c-d", "a--0123abcd"}) {
    EXPECT_TRUE(is_volume_name(name)) << name;
  }
  for (const char* text : {"", "~", "a~", "~a", "a~~b", "a b", "ä", "-a", "a.", "*", "a/b"}) {
    EXPECT_FALSE(is_volume_name(text)) << text;
  }
}

class NamedSources : public ::testing::Test {
 protected:
  NamedSources() {
    for (const char* name : {"a/ct/old", "b/ct", "mr", "a/.hidden"}) {
      std::filesystem::create_directories(folder.path() / name);
    }
  }

  /// "LABEL:PATH" of each source, without the folder of the test.
  Names named(const Names& sources) const {
    std::vector<std::filesystem::path> paths;
    for (const std::string& source : sources)
      paths.push_back(folder.path().string() + "/" + source);
    Names result;
    for (const NamedSource& source : named_sources(paths)) {
      result.push_back(source.label + ":" + source.path.lexically_relative(folder.path()).string());
    }
    return result;
  }

  TemporaryFolder folder;
};

TEST_F(NamedSources, HaveALabelIfThereAreSeveral) {
  EXPECT_EQ(named({"a"}), Names{":a"});
  EXPECT_EQ(named({"a/"}), Names{":a"});
  EXPECT_EQ(named({"x.isosplat", "y.isosplat"}), (Names{":x.isosplat", ":y.isosplat"}));
  EXPECT_EQ(named({"a", "mr"}), (Names{"a:a", "mr:mr"}));
  EXPECT_EQ(named({"mr", "a/ct"}), (Names{"mr:mr", "ct:a/ct"}));
  EXPECT_EQ(named({"mr", "a/x.isosplat"}), (Names{"mr:mr", "a:a/x.isosplat"}));
  EXPECT_EQ(named({"a/x.isosplat", "b/x.isosplat"}), (Names{"a:a/x.isosplat", "b:b/x.isosplat"}));
}

TEST_F(NamedSources, WithinAnotherAddNothing) {
  EXPECT_EQ(named({"a", "a/ct"}), Names{":a"});
  EXPECT_EQ(named({"a/ct/old", "a/ct/x.isosplat", "a"}), Names{":a"});
  EXPECT_EQ(named({"a", "a", "a/"}), Names{":a"});
  EXPECT_EQ(named({"a", "a/.hidden"}), (Names{"a:a", named({"a", "a/.hidden"})[1]}));
  EXPECT_EQ(named({"a", "a/.hidden"}).size(), 2u) << "a listing of the first does not find it";
}

TEST_F(NamedSources, OfEqualNamesHaveAHashOfTheirPath) {
  const Names both = named({"a/ct", "b/ct"}), turned = named({"b/ct", "a/ct"});
  EXPECT_TRUE(both[0].starts_with("ct--"));
  EXPECT_TRUE(both[1].starts_with("ct--"));
  EXPECT_NE(both[0].substr(0, both[0].find(':')), both[1].substr(0, both[1].find(':')));
  EXPECT_EQ(both, (Names{turned[1], turned[0]}));
}

/// Servers with one token for a name, and a link for it, which are started again and again while
/// stores come and go.
class Rights : public ServerTest {
 protected:
  Rights() {
    std::filesystem::remove(folder.path() / "alpha.isosplat");
    options.token_file = secrets.path() / "tokens";
    options.link_key = std::string(32, 'k');
    grant("nothing");
  }

  void write_store(const std::string& path, const KnownStore& store) const {
    std::filesystem::create_directories((folder.path() / path).parent_path());
    write_file(folder.path() / path, store.file);
  }

  void grant(const std::string& patterns) const {
    write_file(options.token_file, kAll + " *\n" + kOne + " " + patterns + "\n");
  }

  void restart() {
    server.reset();
    start();
  }

  Names listed(const std::string& token) const {
    Names names;
    const Answer answer = get(port(), "/v1/volumes", "Authorization: Bearer " + token + "\r\n");
    const Json list = Json::parse(answer.body);
    for (const Json& volume : list["volumes"]) names.push_back(volume["name"]);
    return names;
  }

  /// The name of the store with this content.
  std::string name_of(const KnownStore& store) const {
    for (const Server::Volume& volume : server->volumes()) {
      if (volume.content == store.content) return volume.name;
    }
    return "(none)";
  }

  /// The contents to which the token, or a link for `name`, grants access.
  std::set<std::string> readable(const std::string& name) const {
    std::set<std::string> contents;
    const std::string expires = "4000000000";
    const std::string link =
        "exp=" + expires + "&sig=" + sign_link(options.link_key, ServedKind::volume, name, expires);
    for (const Server::Volume& volume : server->volumes()) {
      const std::string url = "/v1/volumes/" + volume.name;
      const std::string bearer = "Authorization: Bearer " + kOne + "\r\n";
      if (get(port(), url, bearer).status == 200) contents.insert(volume.content);
      if (get(port(), url + "?" + link).status == 200) contents.insert(volume.content);
      const std::string thumbnail = url + "/" + volume.content + "/thumbnail.webp";
      EXPECT_EQ(get(port(), thumbnail, bearer).status, 404) << "there is none";
      const std::string samples = url + "/" + volume.content + "/samples?isovalue=1e9";
      EXPECT_EQ(get(port(), samples, bearer).status == 200, contents.contains(volume.content));
    }
    return contents;
  }

  const std::string kAll = "0123456789abcdef-all", kOne = "0123456789abcdef-one";
  const KnownStore mine = make_store(2), other = make_store(3), third = make_store(4);
  TemporaryFolder secrets;
};

using Contents = std::set<std::string>;

TEST_F(Rights, DoNotMoveToAStoreWhoseNameWouldBecomeTheSame) {
  write_store("a-b.isosplat", mine);
  grant("a-b");
  restart();
  EXPECT_EQ(name_of(mine), "a-b");
  EXPECT_EQ(readable("a-b"), Contents{mine.content});
  for (const char* twin : {"a b", "-a-b", "a-b.", "a?b", "a\nb", "a~b", "aäb"}) {
    write_store(twin + std::string(".isosplat"), other);
    EXPECT_TRUE(
        eventually([&] { return name_of(other) != "(none)"; }));  // a change that is followed
    const std::string followed = name_of(other);
    EXPECT_EQ(readable("a-b"), Contents{mine.content}) << twin;
    restart();
    EXPECT_EQ(name_of(other), followed) << twin;
    EXPECT_EQ(readable("a-b"), Contents{mine.content}) << twin;
    // After the first store is removed, its name has no meaning.
    std::filesystem::remove(folder.path() / "a-b.isosplat");
    restart();
    EXPECT_EQ(name_of(other), followed) << twin;
    EXPECT_EQ(readable("a-b"), Contents{}) << twin;
    write_store("a-b.isosplat", mine);
    std::filesystem::remove(folder.path() / (twin + std::string(".isosplat")));
    restart();
  }
}

TEST_F(Rights, ToAnAlteredNameApplyToThisFileAlone) {
  write_store("a b.isosplat", mine);
  restart();
  const std::string name = name_of(mine);
  grant(name);
  restart();
  EXPECT_EQ(readable(name), Contents{mine.content});
  write_store("a-b.isosplat", other);
  write_store("a?b.isosplat", third);
  restart();
  EXPECT_EQ(readable(name), Contents{mine.content});
  // A file whose name equals the name of the volume.
  std::filesystem::remove(folder.path() / "a b.isosplat");
  write_store(name + ".isosplat", other);
  restart();
  EXPECT_EQ(readable(name), Contents{});
}

TEST_F(Rights, ToEqualNamesInTwoFoldersStayInTheirFolder) {
  write_store("one/head.isosplat", mine);
  std::filesystem::create_directory(folder.path() / "two");
  for (const bool is_turned : {false, true}) {
    options.stores = {folder.path() / "one", folder.path() / "two"};
    if (is_turned) std::swap(options.stores[0], options.stores[1]);
    write_store("one/head.isosplat", mine);
    std::filesystem::remove(folder.path() / "two/head.isosplat");
    restart();
    const std::string name = name_of(mine);
    EXPECT_EQ(name, "one~head");
    grant(name);
    write_store("two/head.isosplat", other);
    restart();
    EXPECT_EQ(readable(name), Contents{mine.content});
    EXPECT_EQ(readable("head"), Contents{mine.content})
        << "by the token: a link for head is of none";
    std::filesystem::remove(folder.path() / "one/head.isosplat");
    restart();
    EXPECT_EQ(readable(name), Contents{});
  }
}

TEST_F(Rights, OfPatternsAreComparedWithTheUnalteredPath) {
  write_store("a-b-1.isosplat", mine);
  write_store("a b-2.isosplat", other);
  write_store("Müller/x y.isosplat", third);
  grant("a-b*");
  restart();
  EXPECT_EQ(readable("-"), Contents{mine.content}) << "\"a b-2\" does not begin with a-b";
  grant("Müller~*");
  restart();
  EXPECT_EQ(readable("-"), Contents{third.content});
  grant(name_segment("Müller") + "~x*");
  restart();
  EXPECT_EQ(readable("-"), Contents{third.content});
  grant("M-ller*~*");
  restart();
  EXPECT_EQ(readable("-"), Contents{});
}

TEST_F(Rights, OfAPathAreOfThisStore) {
  write_store("ct/head.isosplat", mine);
  write_store("ct/head.isosplat.isosplat", other);
  write_store("mr/head.isosplat", third);
  grant((folder.path() / "ct/head.isosplat").string());
  restart();
  EXPECT_EQ(readable("-"), Contents{mine.content});
  // The same if the sources change.
  options.stores = {folder.path() / "mr", folder.path() / "ct"};
  restart();
  EXPECT_EQ(readable("-"), Contents{mine.content});
}

TEST_F(Rights, AChangeOfWhatANameMeansIsLogged) {
  write_store("head.isosplat", mine);
  grant("head");
  restart();
  EXPECT_TRUE(eventually([&] { return name_of(mine) == "head"; }));
  write_store("head.isosplat", other);
  EXPECT_TRUE(eventually([&] { return name_of(other) == "head"; }));
  EXPECT_TRUE(will_log(other.content + " in place of " + mine.content));
  std::filesystem::remove(folder.path() / "head.isosplat");
  EXPECT_TRUE(eventually([&] { return !server->has_stores(); }));
  write_store("head.isosplat", third);
  EXPECT_TRUE(eventually([&] { return name_of(third) == "head"; }));
  EXPECT_TRUE(will_log(third.content + " in place of " + other.content));
}

TEST_F(Rights, AFolderThatDisappearsIsNoVolume) {
  write_store("ct/head.isosplat", mine);
  options.stores = {folder.path() / "ct"};
  grant("*");
  restart();
  EXPECT_EQ(listed(kAll), Names{"head"});
  std::filesystem::rename(folder.path() / "ct", folder.path() / "away");
  EXPECT_TRUE(eventually([&] { return listed(kAll).empty(); }));
  EXPECT_TRUE(will_log("expected a folder of stores, found none"));
  std::filesystem::rename(folder.path() / "away", folder.path() / "ct");
  EXPECT_TRUE(eventually([&] { return listed(kAll) == Names{"head"}; }));
}

TEST_F(Rights, LinksOutOfTheFolderAreNotFollowedIfTheOperatorForbidsIt) {
  TemporaryFolder elsewhere;
  write_file(elsewhere.path() / "secret.isosplat", other.file);
  write_store("ct/head.isosplat", mine);
  grant("*");
  const auto link = [&](const std::filesystem::path& target, const std::string& name) {
    std::filesystem::remove(folder.path() / name);
    std::filesystem::create_symlink(target, folder.path() / name);
  };
  link(folder.path() / "ct/head.isosplat", "inside.isosplat");
  link(elsewhere.path() / "secret.isosplat", "outside.isosplat");
  link("../" + elsewhere.path().filename().string() + "/secret.isosplat", "relative.isosplat");
  restart();
  EXPECT_EQ(listed(kAll), (Names{"ct~head", "inside", "outside", "relative"}));
  options.follow_outside_links = false;
  restart();
  EXPECT_EQ(listed(kAll), (Names{"ct~head", "inside"}));
  EXPECT_TRUE(will_log("outside.isosplat: not served: it is a link out of the folder"));
  // While a link is served, another link in its chain is changed so that it leads out of the
  // folder.
  link(elsewhere.path() / "secret.isosplat", "ct/step.isosplat");
  link("ct/step.isosplat", "inside.isosplat");
  EXPECT_TRUE(eventually([&] { return listed(kAll) == Names{"ct~head"}; }));
  link("ct/head.isosplat", "inside.isosplat");
  EXPECT_TRUE(eventually([&] { return listed(kAll) == (Names{"ct~head", "inside"}); }));
}

TEST_F(Rights, AWarningNamesFilesOfSecretsThatAllUsersCanRead) {
  grant("*");
  ::chmod(options.token_file.c_str(), 0600);
  restart();
  EXPECT_FALSE(log_mentions("all users of this machine"));
  ::chmod(options.token_file.c_str(), 0644);
  EXPECT_TRUE(server->reload());
  EXPECT_TRUE(will_log("all users of this machine can read it"));
  ::chmod(options.token_file.c_str(), 0602);
  restart();
  EXPECT_TRUE(will_log("all users of this machine can change it"));
}

}  // namespace
}  // namespace isosplat::server::test
