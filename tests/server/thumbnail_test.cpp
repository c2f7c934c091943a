// The picture beside a store: which files are served as one, and when the list names it.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "server/catalog/thumbnail.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;
using Bytes = std::vector<std::byte>;

/// A PNG of one black pixel.
Bytes tiny_png() {
  const unsigned char bytes[] = {0x89, 'P', 'N', 'G',  0x0d, 0x0a, 0x1a, 0x0a, 0,    0, 0, 0x0d,
                                 'I',  'H', 'D', 'R',  0,    0,    0,    1,    0,    0, 0, 1,
                                 8,    0,   0,   0,    0,    0x3a, 0x7e, 0x9b, 0x55, 0, 0, 0,
                                 0x0a, 'I', 'D', 'A',  'T',  0x78, 0x9c, 0x63, 0x60, 0, 0, 0,
                                 2,    0,   1,   0x48, 0xaf, 0xa4, 0x71, 0,    0,    0, 0, 'I',
                                 'E',  'N', 'D', 0xae, 0x42, 0x60, 0x82};
  const auto all = std::as_bytes(std::span(bytes));
  return {all.begin(), all.end()};
}

const std::string kContent = "00112233445566778899aabbccddeeff";

Bytes joined(std::initializer_list<std::span<const std::byte>> parts) {
  Bytes all;
  for (const auto part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

TEST(Thumbnail, IsAPngThatNamesTheContent) {
  const Bytes png = with_content_id(tiny_png(), kContent);
  EXPECT_TRUE(is_thumbnail(png, kContent));
  EXPECT_FALSE(is_thumbnail(png, "10112233445566778899aabbccddeeff"));
  EXPECT_FALSE(is_thumbnail(tiny_png(), kContent));
  EXPECT_FALSE(is_thumbnail({}, kContent));
}

TEST(Thumbnail, IsRefusedWithAnyByteChangedMissingOrAdded) {
  const Bytes png = with_content_id(tiny_png(), kContent);
  for (size_t i = 0; i < png.size(); ++i) {
    Bytes changed = png;
    changed[i] ^= std::byte{0x20};
    EXPECT_FALSE(is_thumbnail(changed, kContent)) << "byte " << i;
    EXPECT_FALSE(is_thumbnail(std::span(png).first(i), kContent)) << "first " << i << " bytes";
  }
  Bytes longer = png;
  longer.push_back({});
  EXPECT_FALSE(is_thumbnail(longer, kContent));
}

TEST(Thumbnail, HasNoFurtherChunks) {
  EXPECT_FALSE(
      is_thumbnail(with_content_id(with_content_id(tiny_png(), kContent), kContent), kContent))
      << "a second text";
  const Bytes png = with_content_id(tiny_png(), kContent);
  const auto all = std::span<const std::byte>(png);
  const auto end = all.last(12), pixels = all.last(12 + 22).first(22);
  const auto before = all.first(png.size() - 12);
  EXPECT_TRUE(is_thumbnail(joined({before, pixels, end}), kContent));
  EXPECT_FALSE(is_thumbnail(joined({before, end, end}), kContent));
  EXPECT_FALSE(is_thumbnail(joined({all.first(before.size() - 22), end}), kContent)) << "no pixels";
}

TEST(Thumbnail, IsAtMostOneMebibyte) {
  const Bytes png = with_content_id(tiny_png(), kContent);
  const auto all = std::span<const std::byte>(png);
  Bytes large(all.begin(), all.end() - 12);
  while (large.size() + 12 <= kMaxThumbnailBytes) {
    const auto pixels = all.last(12 + 22).first(22);
    large.insert(large.end(), pixels.begin(), pixels.end());
  }
  large.insert(large.end(), all.end() - 12, all.end());
  EXPECT_FALSE(is_thumbnail(large, kContent));
  large.erase(large.end() - 12 - 22, large.end() - 12);
  EXPECT_TRUE(is_thumbnail(large, kContent));
}

class ThumbnailRoute : public ServerTest {
 protected:
  std::filesystem::path path() const { return folder.path() / "alpha.isosplat.png"; }
  std::string url() const { return content("thumbnail.png"); }

  /// The address in the list; empty: none.
  std::string listed() const {
    const Json list = Json::parse(get(port(), "/v1/volumes").body);
    return list["volumes"][0].value("thumbnail", "");
  }
};

TEST_F(ThumbnailRoute, SendsThePictureOfThePresentContent) {
  const Bytes png = with_content_id(tiny_png(), alpha.content);
  write_file(path(), png);
  start();
  EXPECT_EQ(listed(), url());
  const Answer answer = get(port(), url());
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, text_of(png));
  EXPECT_EQ(answer.header("content-type"), "image/png");
  EXPECT_EQ(answer.header("cache-control"), "no-cache");
  EXPECT_EQ(answer.header("x-content-type-options"), "nosniff");
  const std::string etag = answer.header("etag");
  EXPECT_EQ(get(port(), url(), "If-None-Match: " + etag + "\r\n").status, 304);
  // Another picture of the same store has this URL as well.
  const std::span all(png);  // the same with its pixels in two chunks
  const Bytes other = joined({all.first(png.size() - 12), all.last(34).first(22), all.last(12)});
  write_file(path(), other);
  const Answer replaced = get(port(), url(), "If-None-Match: " + etag + "\r\n");
  EXPECT_EQ(replaced.status, 200);
  EXPECT_EQ(replaced.body, text_of(other));
  write_file(path(), png);
  Client client(port());
  const std::string head = "HEAD " + url() + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  ASSERT_TRUE(client.send(head));
  EXPECT_EQ(client.receive(true).header("content-length"), std::to_string(png.size()));
}

TEST_F(ThumbnailRoute, RefusesOtherFiles) {
  const Bytes png = with_content_id(tiny_png(), alpha.content);
  Bytes damaged = png;
  damaged[png.size() - 20] ^= std::byte{1};
  const Bytes other = with_content_id(tiny_png(), kContent);
  write_file(path(), other);
  start();
  EXPECT_EQ(listed(), "") << "a picture of another content";
  EXPECT_EQ(get(port(), url()).status, 404);
  for (const Bytes& bytes : {Bytes{}, tiny_png(), damaged}) {
    write_file(path(), bytes);
    EXPECT_EQ(get(port(), url()).status, 404) << bytes.size() << " bytes";
  }
  std::filesystem::remove(path());
  ASSERT_EQ(::mkfifo(path().c_str(), 0600), 0);
  EXPECT_EQ(get(port(), url()).status, 404) << "a pipe";
  std::filesystem::remove(path());
  std::filesystem::create_directory(path());
  EXPECT_EQ(get(port(), url()).status, 404) << "a folder";
}

TEST_F(ThumbnailRoute, TheListNamesOnlyPicturesThatAreSent) {
  const Bytes png = with_content_id(tiny_png(), alpha.content);
  write_file(path(), std::span(png).first(png.size() - 20));
  start();
  EXPECT_EQ(listed(), "");
  EXPECT_EQ(get(port(), url()).status, 404);
  write_file(path(), png);
  EXPECT_TRUE(eventually([&] { return listed() == url(); }));
}

TEST_F(ThumbnailRoute, NoticesPicturesThatComeAndGo) {
  start();
  EXPECT_EQ(listed(), "");
  EXPECT_EQ(get(port(), url()).status, 404);
  write_file(path(), with_content_id(tiny_png(), alpha.content));
  EXPECT_TRUE(eventually([&] { return listed() == url(); }));
  std::filesystem::remove(path());
  EXPECT_TRUE(eventually([&] { return listed().empty(); }));
}

TEST_F(ThumbnailRoute, NoticesAPictureBesideAStoreThatIsServedByItsName) {
  options.stores = {folder.path() / "alpha.isosplat"};
  start();
  EXPECT_EQ(listed(), "");
  write_file(path(), with_content_id(tiny_png(), alpha.content));
  EXPECT_TRUE(eventually([&] { return listed() == url(); }));
}

}  // namespace
}  // namespace isosplat::server::test
