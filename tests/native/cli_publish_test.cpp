// isosplat publish: the files of a static site, and the files that it never overwrites.

#include <nlohmann/json.hpp>

#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Ended;
using test::read_file;
using test::run;
using test::TempFolder;
using test::write_ball;
using test::write_file;
using Json = nlohmann::json;

/// A page, two stores, and the folder of a site that does not exist yet.
class CliPublish : public ::testing::Test {
 protected:
  CliPublish() {
    std::filesystem::create_directories(folder / "page/assets");
    write_file(page / "index.html", "<!doctype html><html><head><title>x</title></head></html>");
    write_file(page / "index.html.br", "compressed");
    write_file(page / "assets/main-12345678.js", "program");
    std::filesystem::create_directory(stores);
    build("one", 12);
    build("two", 14);
  }

  void build(const std::string& name, int n) {
    const Ended built = run({"build", write_ball(folder, n, name), "-o",
                             stores / (name + ".isosplat"), "--force", "--no-thumbnail"});
    ASSERT_EQ(built.exit_code, 0) << built.err;
  }

  Ended publish(const std::vector<std::string>& from, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"publish"};
    arguments.insert(arguments.end(), from.begin(), from.end());
    arguments.insert(arguments.end(), {"--to", site, "--web-root", page});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  Json catalog() const { return Json::parse(read_file(site / "catalog.json")); }

  /// All files of the site, relative to it, sorted.
  std::vector<std::string> site_files() const {
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(site)) {
      if (entry.is_regular_file()) files.push_back(entry.path().lexically_relative(site));
    }
    std::ranges::sort(files);
    return files;
  }

  std::string file_of(size_t volume) const { return catalog()["volumes"][volume]["file"]; }

  const TempFolder folder;
  const std::filesystem::path page = folder / "page", stores = folder / "stores",
                              site = folder / "site";
};

TEST_F(CliPublish, WritesThePageTheCatalogAndTheStores) {
  const Ended ended = publish({stores});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const Json volumes = catalog()["volumes"];
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_EQ(volumes[0]["name"], "one");
  EXPECT_EQ(volumes[1]["name"], "two");
  EXPECT_EQ(volumes[1]["voxels"], Json({14, 14, 14}));
  for (const Json& volume : volumes) {
    const std::string name = volume["name"], content = volume["contentId"];
    EXPECT_EQ(volume["file"], "stores/" + name + "-" + content + ".isosplat");
    const std::string copy = read_file(site / volume["file"].get<std::string>());
    EXPECT_EQ(copy, read_file(stores / (name + ".isosplat")));
    EXPECT_EQ(copy.size(), volume["fileBytes"]);
  }
  // The page's encodings lack the elements that name the catalog.
  EXPECT_EQ(site_files(), (std::vector<std::string>{"assets/main-12345678.js", "catalog.json",
                                                    "index.html", file_of(0), file_of(1)}));
  EXPECT_EQ(read_file(site / "assets/main-12345678.js"), "program");
  const std::string index = read_file(site / "index.html");
  EXPECT_NE(index.find("<head><meta name=\"isosplat-catalog\" content=\"catalog.json\">"),
            std::string::npos)
      << index;
}

TEST_F(CliPublish, AScenesStoresArePublishedInItsBundle) {
  const auto run_folder = stores / "run";
  std::filesystem::create_directory(run_folder);
  std::filesystem::rename(stores / "two.isosplat", run_folder / "two.isosplat");
  write_file(run_folder / "scene.json", R"({"format":"isosplat-scene","version":1,"name":"Run",)"
                                        R"("layers":[{"store":"two.isosplat"}]})");
  ASSERT_EQ(run({"bundle", run_folder / "scene.json", "-o", folder / "run.isobundle"}).exit_code,
            0);
  const std::string picture = folder / "picture.webp";
  ASSERT_EQ(run({"render", folder / "run.isobundle", "--size", "48x30", "-o", picture}).exit_code,
            0);
  write_file(run_folder / "scene.json.webp", read_file(picture));
  const Ended ended = publish({stores});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.out.find("a site of 1 scene and 1 volume"), std::string::npos) << ended.out;
  ASSERT_EQ(catalog()["volumes"].size(), 1u);
  EXPECT_EQ(catalog()["volumes"][0]["name"], "one");
  const Json scene = catalog()["scenes"][0];
  EXPECT_EQ(scene["name"], "run~scene");
  EXPECT_EQ(scene["title"], "Run");
  EXPECT_EQ(scene["layers"], 1);
  const std::string content = scene["contentId"];
  EXPECT_EQ(scene["file"], "stores/run~scene-" + content + ".isobundle");
  const std::string published = read_file(site / scene["file"].get<std::string>());
  EXPECT_EQ(published, read_file(folder / "run.isobundle"));
  EXPECT_EQ(published.size(), scene["fileBytes"]);
  EXPECT_EQ(read_file(site / scene["thumbnail"].get<std::string>()), read_file(picture));
  // A store that is named on the command line is also published as a volume.
  ASSERT_EQ(publish({run_folder, run_folder / "two.isosplat"}, {"--prune"}).exit_code, 0);
  const Ended both = publish({run_folder / "scene.json", run_folder / "two.isosplat"});
  ASSERT_EQ(both.exit_code, 0) << both.err;
  EXPECT_EQ(catalog()["volumes"].size(), 1u) << both.out;
  EXPECT_EQ(catalog()["scenes"].size(), 1u) << both.out;
  // If a scene cannot be read, the program ends before it writes anything.
  write_file(run_folder / "bad.scene.json",
             R"({"format":"isosplat-scene","version":1,"layers":[{"store":"none.isosplat"}]})");
  const std::string before = read_file(site / "catalog.json");
  const Ended bad = publish({stores});
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_NE(bad.err.find("none.isosplat"), std::string::npos) << bad.err;
  EXPECT_EQ(read_file(site / "catalog.json"), before);
}

TEST_F(CliPublish, StoresOfSubfoldersButNotThoseOfTheSite) {
  std::filesystem::create_directory(stores / "ct");
  std::filesystem::rename(stores / "two.isosplat", stores / "ct/two.isosplat");
  for (int round = 0; round < 2; ++round) {  // the site is in the folder that is published
    const Ended ended = publish({folder.path()});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    ASSERT_EQ(catalog()["volumes"].size(), 2u) << ended.out;
    EXPECT_EQ(catalog()["volumes"][0]["name"], "stores~ct~two");
    EXPECT_TRUE(file_of(0).starts_with("stores/stores~ct~two-")) << file_of(0);
    EXPECT_TRUE(std::filesystem::exists(site / file_of(0)));
  }
}

TEST_F(CliPublish, PublishedAgainTheSiteGetsWhatIsNewAndKeepsTheRest) {
  ASSERT_EQ(publish({stores}).exit_code, 0);
  const std::string one = file_of(0), two = file_of(1);
  const auto written = std::filesystem::last_write_time(site / one);
  build("two", 16);
  write_file(page / "assets/main-87654321.js", "new program");
  std::filesystem::remove(page / "assets/main-12345678.js");
  const Ended again = publish({stores});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(file_of(0), one);
  EXPECT_EQ(std::filesystem::last_write_time(site / one), written) << "copied again";
  EXPECT_NE(file_of(1), two);
  EXPECT_EQ(site_files().size(), 7u) << "visitors of the old page still read the old files";

  const Ended pruned = publish({stores / "two.isosplat"}, {"--prune"});
  ASSERT_EQ(pruned.exit_code, 0) << pruned.err;
  EXPECT_EQ(catalog()["volumes"].size(), 1u);
  EXPECT_EQ(site_files(), (std::vector<std::string>{"assets/main-87654321.js", "catalog.json",
                                                    "index.html", file_of(0)}));
}

TEST_F(CliPublish, CopiesThePicturesOfTheStores) {
  const Ended drawn = run({"render", stores / "one.isosplat", "--isovalue", "100", "--size",
                           "32x20", "-o", stores / "one.isosplat.webp"});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  std::filesystem::copy(stores / "one.isosplat.webp", stores / "two.isosplat.webp");
  ASSERT_EQ(publish({stores}).exit_code, 0);
  const std::string picture = catalog()["volumes"][0]["thumbnail"];
  EXPECT_TRUE(picture.starts_with(file_of(0).substr(0, file_of(0).rfind('.')) + "-")) << picture;
  EXPECT_EQ(read_file(site / picture), read_file(stores / "one.isosplat.webp"));
  EXPECT_FALSE(catalog()["volumes"][1].contains("thumbnail")) << "it shows another content";
  ASSERT_EQ(publish({stores}, {"--prune"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(site / picture));
  // Hosts allow caches to keep a picture for ever, so another picture gets another name.
  ASSERT_EQ(run({"render", stores / "one.isosplat", "--isovalue", "120", "--size", "30x20", "-o",
                 stores / "one.isosplat.webp"})
                .exit_code,
            0);
  ASSERT_EQ(publish({stores}).exit_code, 0);
  const std::string other = catalog()["volumes"][0]["thumbnail"];
  EXPECT_NE(other, picture);
  EXPECT_EQ(read_file(site / other), read_file(stores / "one.isosplat.webp"));
  ASSERT_EQ(publish({stores / "two.isosplat"}, {"--prune"}).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(site / picture));
  EXPECT_FALSE(std::filesystem::exists(site / other));
}

TEST_F(CliPublish, RepairsAStoreThatIsDamagedInTheSite) {
  ASSERT_EQ(publish({stores}).exit_code, 0);
  const std::string good = read_file(site / file_of(0));
  write_file(site / file_of(0), good.substr(0, good.size() / 2));
  ASSERT_EQ(publish({stores}).exit_code, 0);
  EXPECT_EQ(read_file(site / file_of(0)), good);
}

TEST_F(CliPublish, WritesIntoAFolderWithOtherFilesOnlyByForce) {
  std::filesystem::create_directory(site);
  write_file(site / "thesis.txt", "years of work");
  write_file(site / "index.html", "another site");
  const Ended refused = publish({stores});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
  EXPECT_EQ(site_files(), (std::vector<std::string>{"index.html", "thesis.txt"}));
  EXPECT_EQ(read_file(site / "index.html"), "another site");

  ASSERT_EQ(publish({stores}, {"--force", "--prune"}).exit_code, 0);
  EXPECT_EQ(read_file(site / "thesis.txt"), "years of work");
  EXPECT_NE(read_file(site / "index.html"), "another site");
}

TEST_F(CliPublish, NeverOverwritesOrRemovesWhatItReads) {
  // The folder of the page as the site.
  const std::string index = read_file(page / "index.html");
  const Ended page_itself =
      run({"publish", stores, "--to", page, "--web-root", page, "--force", "--prune"});
  EXPECT_EQ(page_itself.exit_code, 2);
  EXPECT_NE(page_itself.err.find("expected an output that is not an input"), std::string::npos);
  EXPECT_EQ(read_file(page / "index.html"), index);

  // A link in the site that leads to a store.
  ASSERT_EQ(publish({stores}).exit_code, 0);
  const std::filesystem::path copy = site / file_of(0);
  build("one", 18);
  const std::string source = read_file(stores / "one.isosplat");
  ASSERT_EQ(publish({stores}).exit_code, 0);
  const std::filesystem::path named = site / file_of(0);
  std::filesystem::remove(named);
  std::filesystem::create_hard_link(stores / "one.isosplat", named);
  EXPECT_EQ(publish({stores}).exit_code, 0) << "it has the content already";
  EXPECT_EQ(read_file(stores / "one.isosplat"), source);

  // A store in the site, which is published to the same site.
  ASSERT_EQ(publish({copy}, {"--prune"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(copy));
}

TEST_F(CliPublish, WritesNothingIfAStoreOrThePageCannotBeRead) {
  const std::string good = read_file(stores / "two.isosplat");
  write_file(stores / "two.isosplat", good.substr(0, good.size() / 2));
  const Ended broken = publish({stores});
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_NE(broken.err.find("two.isosplat"), std::string::npos) << broken.err;
  EXPECT_FALSE(std::filesystem::exists(site));

  EXPECT_EQ(publish({folder / "nothing"}).exit_code, 1);
  std::filesystem::create_directory(folder / "empty");
  const Ended none = publish({folder / "empty"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("at least one store"), std::string::npos) << none.err;
  std::filesystem::remove(page / "index.html");
  const Ended no_page = publish({stores / "one.isosplat"});
  EXPECT_EQ(no_page.exit_code, 2);
  EXPECT_NE(no_page.err.find("index.html"), std::string::npos) << no_page.err;
  EXPECT_FALSE(std::filesystem::exists(site));
}

}  // namespace
}  // namespace isosplat
