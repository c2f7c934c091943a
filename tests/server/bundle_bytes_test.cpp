// The bundle of a scene with separate stores: its bytes and its checksum, and changed and hostile
// files.

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "shared/core/base/status.h"
#include "shared/system/scene_file/bundle_bytes.h"
#include "tests/server/test_store.h"

namespace isosplat::server::test {
namespace {

namespace fs = std::filesystem;

class BundleBytesTest : public ::testing::Test {
 protected:
  BundleBytesTest() {
    fs::create_directories(folder.path() / "run/deep");
    write_file(folder.path() / "run/one.isosplat", one.file);
    write_file(folder.path() / "run/deep/two.isosplat", two.file);
    write_scene("one.isosplat", "deep/two.isosplat");
  }

  void write_text(const std::string& path, const std::string& text) const {
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    write_file(folder.path() / path, {bytes, bytes + text.size()});
  }

  void write_scene(const std::string& first, const std::string& second) const {
    write_text("run/scene.json", R"({"format":"isosplat-scene","version":1,"layers":[{"store":")" +
                                     first + R"("},{"store":")" + second + R"("}]})");
  }

  Result<BundleBytes> plan(const std::optional<fs::path>& within = {}) const {
    const auto scene = SceneFile::open(folder.path() / "run/scene.json");
    if (!scene) return tl::unexpected(scene.error());
    return BundleBytes::plan(*scene, within);
  }

  static std::vector<std::byte> read_all(const BundleBytes& bundle) {
    std::vector<std::byte> bytes(bundle.bytes());
    const auto read = bundle.read(0, bytes);
    EXPECT_TRUE(read) << read.error().message;
    return bytes;
  }

  TemporaryFolder folder;
  const KnownStore one = make_store(1), two = make_store(2, {40, 30, 20});
};

TEST_F(BundleBytesTest, BeginsWithTheStepThatIsShownFirst) {
  write_text("run/scene.json", R"({"format":"isosplat-scene","version":1,"layers":[)"
                               R"({"stores":["one.isosplat","deep/two.isosplat"]}],)"
                               R"("time":{"steps":[0,1],"step":1}})");
  const auto bundle = plan();
  ASSERT_TRUE(bundle) << bundle.error().message;
  const BundleHeader& header = bundle->header();
  ASSERT_EQ(header.stores.size(), 2u);
  EXPECT_EQ(header.stores[0].path, "deep/two.isosplat");
  EXPECT_EQ(header.stores[0].coarse_offset, header.header_bytes);
  EXPECT_EQ(bundle->first_bytes(), header.header_bytes + header.stores[0].coarse_bytes());
}

TEST_F(BundleBytesTest, HasTheLayoutOfABundle) {
  const auto bundle = plan();
  ASSERT_TRUE(bundle) << bundle.error().message;
  const std::vector<std::byte> bytes = read_all(*bundle);
  const auto header = parse_bundle_header(std::span(bytes).first(bundle->header().header_bytes));
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_EQ(header->file_bytes, bytes.size());
  // Each part is at the offset that BUNDLE.md defines. The test computes the offsets from the
  // records.
  uint64_t coarse = header->header_bytes, fine = header->header_bytes + header->coarse_bytes;
  EXPECT_EQ(bundle->first_bytes(), fine);
  const std::vector<std::byte>* files[] = {&one.file, &two.file};
  ASSERT_EQ(header->stores.size(), 2u);
  const auto expect_part = [&](uint64_t at, const std::vector<std::byte>& file, uint64_t begin,
                               uint64_t end) {
    ASSERT_LE(at + (end - begin), bytes.size());
    EXPECT_TRUE(std::equal(file.begin() + static_cast<ptrdiff_t>(begin),
                           file.begin() + static_cast<ptrdiff_t>(end),
                           bytes.begin() + static_cast<ptrdiff_t>(at)));
  };
  for (size_t i = 0; i < 2; ++i) {
    const BundleStore& store = header->stores[i];
    const uint64_t end = store.bootstrap_offset + store.bootstrap_bytes;
    ASSERT_EQ(store.file_bytes, files[i]->size());
    expect_part(coarse, *files[i], 0, store.header_bytes);
    expect_part(coarse + store.header_bytes, *files[i], store.bootstrap_offset, end);
    expect_part(fine, *files[i], store.header_bytes, store.bootstrap_offset);
    expect_part(fine + store.bootstrap_offset - store.header_bytes, *files[i], end,
                files[i]->size());
    coarse += store.header_bytes + store.bootstrap_bytes;
    fine += store.file_bytes - store.header_bytes - store.bootstrap_bytes;
  }
  EXPECT_EQ(fine, bytes.size());
}

TEST_F(BundleBytesTest, ManyVisibleLayersShareTheBytesOfTheFirstPicture) {
  const KnownStore large = make_store(3, {140, 140, 140}, 200);
  const auto reader = StoreReader::open(
      std::span(large.file).first(std::min<size_t>(large.file.size(), kMaxStoreHeaderBytes)));
  ASSERT_TRUE(reader) << reader.error().message;
  constexpr size_t kLayers = 32;
  const auto with_layers = [&](size_t visible) {
    std::string layers;
    for (size_t i = 0; i < kLayers; ++i) {
      const std::string store = std::to_string(i) + ".isosplat";
      write_file(folder.path() / "run" / store, large.file);
      layers += (i > 0 ? "," : "") + (R"({"store":")" + store) + R"(","visible":)" +
                (i < visible ? "true}" : "false}");
    }
    write_text("run/scene.json",
               R"({"format":"isosplat-scene","version":1,"layers":[)" + layers + "]}");
    auto bundle = plan();
    EXPECT_TRUE(bundle) << bundle.error().message;
    return bundle->header();
  };
  const BundleHeader few = with_layers(1), many = with_layers(kLayers);
  const CoarseRange whole = reader->bootstrap_range();
  const CoarseRange shared = reader->bootstrap_range(BundleBytes::kFirstPictureBytes / kLayers -
                                                     reader->info().header_bytes);
  ASSERT_LT(shared.bytes, whole.bytes);  // otherwise nothing is tested
  for (size_t i = 0; i < kLayers; ++i) {
    EXPECT_EQ(few.stores[i].bootstrap_bytes, whole.bytes);
    EXPECT_EQ(many.stores[i].bootstrap_offset, shared.offset);
    EXPECT_EQ(many.stores[i].bootstrap_bytes, shared.bytes);
  }
}

TEST_F(BundleBytesTest, ReadsAnyRange) {
  const auto bundle = plan();
  ASSERT_TRUE(bundle) << bundle.error().message;
  const std::vector<std::byte> bytes = read_all(*bundle);
  std::mt19937_64 random(7);
  for (int i = 0; i < 500; ++i) {
    const uint64_t offset = random() % (bytes.size() + 1);
    std::vector<std::byte> part(random() % (bytes.size() - offset + 1));
    const auto read = bundle->read(offset, part);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_TRUE(
        std::equal(part.begin(), part.end(), bytes.begin() + static_cast<ptrdiff_t>(offset)));
  }
  std::vector<std::byte> more(2);
  EXPECT_EQ(bundle->read(bytes.size() - 1, more).error().status, Status::truncated);
  EXPECT_EQ(bundle->read(UINT64_MAX, more).error().status, Status::truncated);
}

TEST_F(BundleBytesTest, IsTheSameFromABundleFile) {
  const auto from_scene = plan();
  ASSERT_TRUE(from_scene) << from_scene.error().message;
  const std::vector<std::byte> bytes = read_all(*from_scene);
  write_file(folder.path() / "run.isobundle", bytes);
  const auto file = SceneFile::open(folder.path() / "run.isobundle");
  ASSERT_TRUE(file) << file.error().message;
  const auto from_file = BundleBytes::plan(*file);
  ASSERT_TRUE(from_file) << from_file.error().message;
  EXPECT_EQ(from_file->content(), from_scene->content());
  EXPECT_EQ(from_file->content().size(), 16u);
  EXPECT_EQ(read_all(*from_file), bytes);
}

TEST_F(BundleBytesTest, RefusesFilesThatChanged) {
  const auto before = plan();
  ASSERT_TRUE(before) << before.error().message;
  EXPECT_TRUE(before->is_current());
  write_file(folder.path() / "run/new", make_store(3).file);
  fs::rename(folder.path() / "run/new", folder.path() / "run/one.isosplat");
  EXPECT_FALSE(before->is_current());
  std::vector<std::byte> all(before->bytes());
  EXPECT_EQ(before->read(0, all).error().status, Status::io_error);
  // The header stays readable, since it is in memory.
  EXPECT_TRUE(before->read(0, std::span(all).first(64)));
  const auto after = plan();
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_NE(after->content(), before->content());
  fs::remove(folder.path() / "run/deep/two.isosplat");
  EXPECT_FALSE(after->is_current());
  EXPECT_FALSE(after->read(0, all));
  const auto missing = plan();
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("two.isosplat"), std::string::npos);
}

TEST_F(BundleBytesTest, ReadsNoStoresOutsideOfTheFolder) {
  write_file(folder.path() / "secret.isosplat", one.file);
  for (const char* path : {"../secret.isosplat", "/etc/passwd", "https://x.test/a.isosplat"}) {
    write_scene(path, "deep/two.isosplat");
    EXPECT_FALSE(plan()) << path;
  }
  fs::create_symlink(folder.path() / "secret.isosplat", folder.path() / "run/link.isosplat");
  write_scene("link.isosplat", "deep/two.isosplat");
  EXPECT_TRUE(plan());
  const auto refused = plan(folder.path() / "run");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().status, Status::malformed_header);
}

TEST_F(BundleBytesTest, ReportsThatReadsOfStoresNeedTheDisk) {
  const auto bundle = plan();
  ASSERT_TRUE(bundle) << bundle.error().message;
  NoWait no_wait;
  std::vector<std::byte> part(bundle->header().header_bytes);
  EXPECT_TRUE(bundle->read(0, part, &no_wait));
  EXPECT_FALSE(no_wait.needs_disk);
  part.resize(part.size() + 1);
  EXPECT_FALSE(bundle->read(0, part, &no_wait));
  EXPECT_TRUE(no_wait.needs_disk);
}

}  // namespace
}  // namespace isosplat::server::test
