// Stores that are added, changed, damaged and removed while the server runs; and StoreFile.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "server/catalog/volume_names.h"
#include "shared/system/store_file/store_file.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;

class Stores : public ServerTest {
 protected:
  Json volume(const std::string& name) {
    const Json list = Json::parse(get(port(), "/v1/volumes").body);
    for (const Json& item : list["volumes"]) {
      if (item["name"] == name) return item;
    }
    return nullptr;
  }
};

TEST_F(Stores, ANewStoreAppears) {
  start();
  EXPECT_TRUE(volume("beta").is_null());
  const KnownStore beta = make_store(2);
  write_file(folder.path() / "beta.isosplat", beta.file);
  EXPECT_TRUE(eventually([&] { return !volume("beta").is_null(); }));
  EXPECT_EQ(volume("beta")["contentId"], beta.content);
}

TEST_F(Stores, AReplacedStoreHasOtherUrls) {
  start();
  const std::string old_url = content("header");
  EXPECT_EQ(get(port(), old_url).status, 200);
  const KnownStore other = make_store(3);
  write_file(folder.path() / "alpha.isosplat", other.file);
  EXPECT_TRUE(eventually([&] { return volume("alpha")["contentId"] == other.content; }));
  const Answer answer = get(port(), old_url);
  EXPECT_EQ(answer.status, 404);
  EXPECT_NE(answer.body.find(other.content), std::string::npos);
  EXPECT_EQ(get(port(), "/v1/volumes/alpha/" + other.content + "/file").body, text_of(other.file));
}

TEST_F(Stores, ARemovedStoreIsGone) {
  start();
  std::filesystem::remove(folder.path() / "alpha.isosplat");
  EXPECT_TRUE(eventually([&] { return volume("alpha").is_null(); }));
  EXPECT_EQ(get(port(), content("header")).status, 404);
  EXPECT_TRUE(will_log("alpha was removed"));
}

TEST_F(Stores, AStoreOverwrittenInPlaceIsNotServed) {
  options.scan_interval = std::chrono::hours(1);
  start();
  const KnownChunk& chunk = alpha.chunks.front();
  EXPECT_EQ(get(port(), content("chunks/" + place_of(chunk))).status, 200);
  std::ofstream file(folder.path() / "alpha.isosplat", std::ios::binary | std::ios::app);
  file << "more" << std::flush;
  for (const std::string& rest :
       {"chunks/" + place_of(chunk), std::string("file"), std::string("pages/0")}) {
    const Answer answer = get(port(), content(rest));
    EXPECT_EQ(answer.status, 500) << rest;
    EXPECT_NE(answer.body.find("changed after it was opened"), std::string::npos) << answer.body;
  }
  // When the writer closes the file, the server examines it again.
  file.close();
  EXPECT_TRUE(eventually([&] { return volume("alpha").contains("error"); }));
  EXPECT_EQ(volume("alpha")["error"]["status"], "malformed_header");
}

TEST_F(Stores, BrokenStoresAreListedWithTheirError) {
  const auto cut = [&](size_t bytes) {
    return std::span<const std::byte>(alpha.file).first(bytes);
  };
  write_file(folder.path() / "empty.isosplat", cut(0));
  write_file(folder.path() / "half.isosplat", cut(alpha.file.size() / 2));
  write_file(folder.path() / "magic.isosplat", cut(6));
  write_file(folder.path() / "text.isosplat",
             std::string_view("this is not a store at all ......"));
  std::filesystem::create_directory(folder.path() / "folder.isosplat");
  std::filesystem::create_symlink("nowhere", folder.path() / "dangling.isosplat");
  write_file(folder.path() / "other.txt", std::string_view("ignored"));
  write_file(folder.path() / ".hidden.isosplat", std::string_view("ignored"));
  start();
  EXPECT_EQ(volume("alpha")["contentId"], alpha.content);
  EXPECT_EQ(volume("half")["error"]["status"], "truncated");
  EXPECT_EQ(volume("text")["error"]["status"], "not_a_store");
  EXPECT_EQ(volume("folder")["error"]["status"], "not_a_store");
  EXPECT_EQ(volume("dangling")["error"]["status"], "io_error");
  for (const char* name : {"empty", "magic", "half", "text", "folder", "dangling"}) {
    // The name of the file, not its folder.
    const auto message = volume(name)["error"]["message"].get<std::string>();
    EXPECT_TRUE(message.find(std::string(name) + ".isosplat") == 0) << message;
    EXPECT_EQ(message.find(folder.path().string()), std::string::npos) << message;
    EXPECT_TRUE(will_log(std::string("volume ") + name + " is not served")) << name;
    const Answer answer = get(port(), std::string("/v1/volumes/") + name);
    EXPECT_EQ(answer.status, 500);
    EXPECT_EQ(answer.body.find(folder.path().string()), std::string::npos) << answer.body;
    EXPECT_EQ(get(port(), std::string("/v1/volumes/") + name + "/x/header").status, 500);
  }
  EXPECT_EQ(Json::parse(get(port(), "/v1/volumes").body)["volumes"].size(), 7u);
  EXPECT_EQ(Json::parse(get(port(), "/healthz").body)["broken"], 6);
  // Once the file is repaired, it is served.
  write_file(folder.path() / "half.isosplat", alpha.file);
  EXPECT_TRUE(eventually([&] { return volume("half")["contentId"] == alpha.content; }));
}

TEST_F(Stores, InvalidMetadataIsIgnored) {
  const std::vector<std::string> texts = {
      "not JSON",
      "[1,2,3]",
      "\"text\"",
      "{\"title\":1,\"units\":null,\"source\":[],\"histogram\":\"no\"}",
      "{\"histogram\":{\"low\":\"x\",\"high\":1,\"counts\":[1]}}",
      "{\"histogram\":{\"low\":0,\"high\":1,\"counts\":[]}}",
      "{\"histogram\":{\"low\":0,\"high\":1,\"counts\":[1,\"x\"]}}",
      "{\"histogram\":{\"low\":0,\"high\":1,\"counts\":[[[]]]}}",
      "{\"title\":\"\xff\"}",
      "{\"title\":\"<script>\\u0000\"}",
      "{\"x\":" + std::string(4000, '[') + std::string(4000, ']') + "}",
      std::string(8000, '['),
      std::string(8000, '{'),
  };
  for (size_t i = 0; i < texts.size(); ++i) {
    write_file(folder.path() / ("m" + std::to_string(i) + ".isosplat"),
               make_store(1, {5, 5, 5}, 10, texts[i]).file);
  }
  start();
  for (size_t i = 0; i < texts.size(); ++i) {
    const std::string name = "m" + std::to_string(i);
    const Json listed = volume(name);
    EXPECT_TRUE(listed.contains("contentId")) << listed;
    EXPECT_FALSE(listed.contains("histogram")) << listed;
    const Answer answer = get(port(), "/v1/volumes/" + name);
    EXPECT_EQ(answer.status, 200);
    EXPECT_TRUE(Json::parse(answer.body)["metadata"].is_object()) << answer.body;
  }
}

TEST_F(Stores, NamesAreUniqueAndSafe) {
  TemporaryFolder second;
  write_file(second.path() / "alpha.isosplat", make_store(4).file);
  write_file(folder.path() / "My Scan.isosplat", make_store(5).file);
  write_file(folder.path() / "My  Scan.isosplat", make_store(6).file);
  options.stores = {folder.path() / "alpha.isosplat", folder.path(), second.path()};
  start();
  std::set<std::string> names;
  for (const Server::Volume& item : server->volumes()) {
    EXPECT_TRUE(names.insert(item.name).second);
    EXPECT_EQ(item.error, "");
    EXPECT_EQ(get(port(), "/v1/volumes/" + item.name).status, 200);
  }
  const std::string first = name_segment(folder.path().filename().string()) + "~";
  EXPECT_EQ(names,
            (std::set<std::string>{first + "alpha", first + name_segment("My Scan"),
                                   first + name_segment("My  Scan"),
                                   name_segment(second.path().filename().string()) + "~alpha"}));
}

TEST_F(Stores, AReaderKeepsAReplacedStore) {
  const auto path = folder.path() / "alpha.isosplat";
  const auto store = StoreFile::open(path);
  ASSERT_TRUE(store) << store.error().message;
  write_file(path, make_store(3).file);
  std::vector<std::byte> bytes(alpha.file.size());
  ASSERT_TRUE((*store)->read(0, bytes));
  EXPECT_EQ(bytes, alpha.file);
  EXPECT_FALSE(*file_identity(path) == (*store)->identity());
}

TEST_F(Stores, EveryTruncationIsRefusedAtOpening) {
  const auto path = folder.path() / "cut.isosplat";
  for (size_t bytes = 0; bytes < alpha.file.size(); bytes += 1 + bytes / 16) {
    write_file(path, std::span<const std::byte>(alpha.file).first(bytes));
    const auto store = StoreFile::open(path);
    ASSERT_FALSE(store) << bytes;
    EXPECT_NE(store.error().message.find("cut.isosplat"), std::string::npos);
  }
}

TEST_F(Stores, ManyThreadsOnOneStoreFile) {
  const auto store = StoreFile::open(folder.path() / "alpha.isosplat", 1);
  ASSERT_TRUE(store);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (size_t thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&, thread] {
      std::vector<std::byte> bytes;
      for (size_t i = 0; i < 500; ++i) {
        const KnownChunk& known = alpha.chunks[(i * 13 + thread * 31) % alpha.chunks.size()];
        bytes.clear();
        const auto chunk = (*store)->chunk(known.block, known.band);
        if (!chunk || !(*store)->read_chunk(*chunk, bytes) || bytes != known.bytes) ++wrong;
        const auto quantized = static_cast<float>(known.band_begin);
        const auto found = (*store)->chunk_for(known.block, quantized);
        if (!found || found->has_value() != (known.cells > 0)) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(Stores, ThePageThatIsUsedMostRecentlyStaysInTheDirectory) {
  const KnownStore beta = make_store(4, {1500, 40, 40}, 300);
  const auto path = folder.path() / "beta.isosplat";
  write_file(path, beta.file);
  // A chunk of each page.
  std::vector<const KnownChunk*> chunks;
  uint64_t page_bytes = 0;
  {
    const auto store = StoreFile::open(path);
    ASSERT_TRUE(store);
    for (const PageRef& page : (*store)->pages()) {
      page_bytes += page.bytes;
      const auto is_in_page = [&](const KnownChunk& chunk) {
        return chunk.block.level == page.level && chunk.block.index.x >= page.first_block.x &&
               chunk.block.index.x < page.end_block.x;
      };
      const auto found = std::find_if(beta.chunks.begin(), beta.chunks.end(), is_in_page);
      if (found != beta.chunks.end()) chunks.push_back(&*found);
    }
  }
  ASSERT_GE(chunks.size(), 6u);
  const auto store = StoreFile::open(path, page_bytes / 2);
  ASSERT_TRUE(store);
  const auto is_there = [&](const KnownChunk* known) {
    return (*store)->chunk(known->block, known->band).has_value();
  };
  const KnownChunk* const hot = chunks.front();
  for (size_t round = 0; round < 2; ++round) {
    for (const KnownChunk* other : chunks) EXPECT_TRUE(is_there(hot) && is_there(other));
  }
  ASSERT_TRUE(is_there(hot));

  // From now on, pages cannot be read from the file, so pages that are available were kept in
  // memory. The size and time of the file stay the same, so that it counts as unchanged.
  const auto time = std::filesystem::last_write_time(path);
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    for (const PageRef& page : (*store)->pages()) {
      file.seekp(static_cast<std::streamoff>(page.offset));
      file.write(std::string(page.bytes, 'x').data(), page.bytes);
    }
  }
  std::filesystem::last_write_time(path, time);
  EXPECT_TRUE(is_there(hot));
  const auto kept = std::count_if(chunks.begin(), chunks.end(), is_there);
  EXPECT_GE(kept, 2);
  EXPECT_LT(kept, static_cast<std::ptrdiff_t>(chunks.size()));
}

}  // namespace
}  // namespace isosplat::server::test
