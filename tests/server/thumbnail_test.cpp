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

/// An opaque WebP picture of one pixel, lossless.
Bytes tiny_picture() {
  const unsigned char bytes[] = {
      'R', 'I', 'F', 'F',  0x1a, 0, 0, 0,    'W',  'E',  'B',  'P',  'V',  'P',  '8',  'L',  0x0d,
      0,   0,   0,   0x2f, 0,    0, 0, 0x10, 0x07, 0x10, 0x11, 0x11, 0x88, 0x88, 0xfe, 0x07, 0};
  const auto all = std::as_bytes(std::span(bytes));
  return {all.begin(), all.end()};
}

/// Another one, in which one more byte follows the pixel.
Bytes other_picture() {
  Bytes bytes = tiny_picture();
  bytes[16] = std::byte{0x0e};
  return bytes;
}

const std::string kContent = "00112233445566778899aabbccddeeff";

Bytes joined(std::initializer_list<std::span<const std::byte>> parts) {
  Bytes all;
  for (const auto part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

TEST(Thumbnail, IsAWebPFileThatNamesTheContent) {
  const Bytes webp = with_content_id(tiny_picture(), kContent);
  EXPECT_TRUE(is_thumbnail(webp, kContent));
  EXPECT_FALSE(is_thumbnail(webp, "10112233445566778899aabbccddeeff"));
  EXPECT_FALSE(is_thumbnail(tiny_picture(), kContent));
  EXPECT_FALSE(is_thumbnail({}, kContent));
  EXPECT_FALSE(is_thumbnail(with_content_id(tiny_picture(), ""), ""));
  const std::string scene = kContent.substr(0, 16);
  EXPECT_TRUE(is_thumbnail(with_content_id(tiny_picture(), scene), scene));
}

TEST(Thumbnail, IsRefusedWithAnyByteChangedMissingOrAdded) {
  const Bytes webp = with_content_id(tiny_picture(), kContent);
  for (size_t i = 0; i < webp.size(); ++i) {
    Bytes changed = webp;
    changed[i] ^= std::byte{0x20};
    EXPECT_FALSE(is_thumbnail(changed, kContent)) << "byte " << i;
    EXPECT_FALSE(is_thumbnail(std::span(webp).first(i), kContent)) << "first " << i << " bytes";
  }
  Bytes longer = webp;
  longer.push_back({});
  EXPECT_FALSE(is_thumbnail(longer, kContent));
}

/// A WebP file of these chunks, without a header of the canvas.
Bytes file_of(std::initializer_list<std::span<const std::byte>> chunks) {
  Bytes file = tiny_picture();
  file.resize(12);
  for (const auto chunk : chunks) file.insert(file.end(), chunk.begin(), chunk.end());
  for (size_t i = 0; i < 4; ++i) file[4 + i] = std::byte((file.size() - 8) >> 8 * i);
  return file;
}

TEST(Thumbnail, HasOnlyWhatAStillPictureNeeds) {
  const Bytes picture = tiny_picture();
  const auto pixels = std::span<const std::byte>(picture).subspan(12);
  const Bytes alpha = joined({std::as_bytes(std::span("ALPH", 4)), pixels.subspan(4)});
  const Bytes metadata = joined({std::as_bytes(std::span("EXIF", 4)), pixels.subspan(4)});
  const auto is_accepted = [](const Bytes& webp) {
    return is_thumbnail(with_content_id(webp, kContent), kContent);
  };
  EXPECT_TRUE(is_accepted(file_of({pixels})));
  EXPECT_FALSE(is_accepted(file_of({pixels, pixels})));
  EXPECT_FALSE(is_accepted(file_of({pixels, metadata})));
  const Bytes named = with_content_id(picture, kContent);  // RIFF header, VP8X, id, pixels
  const auto canvas = std::span<const std::byte>(named).subspan(12, 18);
  EXPECT_TRUE(is_accepted(file_of({canvas, alpha, pixels})));
  EXPECT_FALSE(is_accepted(file_of({canvas, metadata, pixels})));
  EXPECT_FALSE(is_accepted(file_of({canvas, alpha, alpha, pixels})));
  EXPECT_FALSE(is_accepted(file_of({canvas, alpha})));
  EXPECT_FALSE(is_accepted(file_of({canvas})));
}

TEST(Thumbnail, HasOneSizeOfAtMost2048Pixels) {
  const auto sized = [](uint32_t canvas, uint32_t pixels) {
    Bytes webp = tiny_picture();
    for (size_t i = 0; i < 2; ++i) webp[21 + i] = std::byte((pixels - 1) >> 8 * i);
    Bytes named = with_content_id(webp, kContent);
    Bytes header(named.begin() + 12, named.begin() + 30);
    header[12] = std::byte(canvas - 1), header[13] = std::byte((canvas - 1) >> 8);
    const std::span<const std::byte> all(webp);
    return is_thumbnail(with_content_id(file_of({header, all.subspan(12)}), kContent), kContent);
  };
  EXPECT_TRUE(sized(1, 1));
  EXPECT_TRUE(sized(2048, 2048));
  EXPECT_FALSE(sized(2049, 2049));
  EXPECT_FALSE(sized(1, 2048));
}

TEST(Thumbnail, IsAtMostOneMebibyte) {
  const auto with_bytes = [](size_t bytes) {
    Bytes webp = tiny_picture();
    const size_t more = bytes - with_content_id(webp, kContent).size();
    webp.insert(webp.end(), more, std::byte{});
    const size_t data = 0x0d + more;
    for (size_t i = 0; i < 4; ++i) webp[16 + i] = std::byte(data >> 8 * i);
    return with_content_id(webp, kContent);
  };
  EXPECT_TRUE(is_thumbnail(with_bytes(kMaxThumbnailBytes), kContent));
  EXPECT_FALSE(is_thumbnail(with_bytes(kMaxThumbnailBytes + 2), kContent));
}

class ThumbnailRoute : public ServerTest {
 protected:
  std::filesystem::path path() const { return folder.path() / "alpha.isosplat.webp"; }
  std::string url() const { return content("thumbnail.webp"); }

  /// The address in the list; empty: none.
  std::string listed() const {
    const Json list = Json::parse(get(port(), "/v1/volumes").body);
    return list["volumes"][0].value("thumbnail", "");
  }
};

TEST_F(ThumbnailRoute, SendsThePictureOfThePresentContent) {
  const Bytes webp = with_content_id(tiny_picture(), alpha.content);
  write_file(path(), webp);
  start();
  EXPECT_EQ(listed(), url());
  const Answer answer = get(port(), url());
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, text_of(webp));
  EXPECT_EQ(answer.header("content-type"), "image/webp");
  EXPECT_EQ(answer.header("cache-control"), "no-cache");
  EXPECT_EQ(answer.header("x-content-type-options"), "nosniff");
  const std::string etag = answer.header("etag");
  EXPECT_EQ(get(port(), url(), "If-None-Match: " + etag + "\r\n").status, 304);
  // Another picture of the same store has this URL as well.
  const Bytes other = with_content_id(other_picture(), alpha.content);
  write_file(path(), other);
  const Answer replaced = get(port(), url(), "If-None-Match: " + etag + "\r\n");
  EXPECT_EQ(replaced.status, 200);
  EXPECT_EQ(replaced.body, text_of(other));
  write_file(path(), webp);
  Client client(port());
  const std::string head = "HEAD " + url() + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  ASSERT_TRUE(client.send(head));
  EXPECT_EQ(client.receive(true).header("content-length"), std::to_string(webp.size()));
}

TEST_F(ThumbnailRoute, RefusesOtherFiles) {
  const Bytes webp = with_content_id(tiny_picture(), alpha.content);
  Bytes damaged = webp;
  damaged[webp.size() - 20] ^= std::byte{1};
  const Bytes other = with_content_id(tiny_picture(), kContent);
  write_file(path(), other);
  start();
  EXPECT_EQ(listed(), "") << "a picture of another content";
  EXPECT_EQ(get(port(), url()).status, 404);
  for (const Bytes& bytes : {Bytes{}, tiny_picture(), damaged}) {
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
  const Bytes webp = with_content_id(tiny_picture(), alpha.content);
  write_file(path(), std::span(webp).first(webp.size() - 20));
  start();
  EXPECT_EQ(listed(), "");
  EXPECT_EQ(get(port(), url()).status, 404);
  write_file(path(), webp);
  EXPECT_TRUE(eventually([&] { return listed() == url(); }));
}

TEST_F(ThumbnailRoute, NoticesPicturesThatComeAndGo) {
  start();
  EXPECT_EQ(listed(), "");
  EXPECT_EQ(get(port(), url()).status, 404);
  write_file(path(), with_content_id(tiny_picture(), alpha.content));
  EXPECT_TRUE(eventually([&] { return listed() == url(); }));
  std::filesystem::remove(path());
  EXPECT_TRUE(eventually([&] { return listed().empty(); }));
}

TEST_F(ThumbnailRoute, NoticesAPictureBesideAStoreThatIsServedByItsName) {
  options.stores = {folder.path() / "alpha.isosplat"};
  start();
  EXPECT_EQ(listed(), "");
  write_file(path(), with_content_id(tiny_picture(), alpha.content));
  EXPECT_TRUE(eventually([&] { return listed() == url(); }));
}

}  // namespace
}  // namespace isosplat::server::test
