// JSON for clients that admit gzip: the same text, separate ETags, Vary, and a limited cost.

#include <gtest/gtest.h>

#include "server/http/gzip.h"
#include "tests/server/server_fixture.h"
#include "tests/server/unzipped.h"

namespace isosplat::server::test {
namespace {

constexpr const char* kGzip = "Accept-Encoding: gzip, deflate, br\r\n";

class Compression : public ServerTest {
 protected:
  Compression() {
    for (int i = 0; i < 40; ++i) {
      write_file(folder.path() / ("volume-" + std::to_string(i) + ".isosplat"), alpha.file);
    }
  }
};

TEST_F(Compression, TheTextIsTheSame) {
  start();
  for (const std::string& path :
       {std::string("/v1/volumes"), std::string("/v1/openapi.json"),
        std::string("/v1/volumes/alpha"), content("isovalues?isovalue=0..1&steps=200")}) {
    const Answer plain = get(port(), path);
    ASSERT_EQ(plain.status, 200) << path << plain.body;
    EXPECT_EQ(plain.header("vary"), "Accept-Encoding") << path;
    EXPECT_EQ(plain.header("content-encoding"), "");
    const Answer small = get(port(), path, kGzip);
    ASSERT_EQ(small.status, 200) << path;
    EXPECT_EQ(small.header("vary"), "Accept-Encoding") << path;
    EXPECT_EQ(small.header("content-type"), "application/json");
    if (plain.body.size() < Compressor::kMinBytes) {
      EXPECT_EQ(small.body, plain.body) << path;
      EXPECT_EQ(small.header("etag"), plain.header("etag"));
      continue;
    }
    EXPECT_EQ(small.header("content-encoding"), "gzip") << path;
    EXPECT_LT(small.body.size(), plain.body.size() / 2) << path;
    EXPECT_EQ(unzipped(small.body), plain.body) << path;
    EXPECT_NE(small.header("etag"), plain.header("etag")) << "other bytes";
    EXPECT_EQ(small.header("cache-control"), plain.header("cache-control"));
    const Answer head = Client(port()).request("HEAD", path, kGzip);
    EXPECT_EQ(head.header("content-length"), std::to_string(small.body.size())) << path;
    EXPECT_EQ(head.header("etag"), small.header("etag"));
    // A request with either ETag gets 304 with this ETag.
    for (const Answer& known : {plain, small}) {
      const Answer same =
          get(port(), path, kGzip + ("If-None-Match: " + known.header("etag") + "\r\n"));
      EXPECT_EQ(same.status, 304) << path;
      EXPECT_EQ(same.header("etag"), known.header("etag"));
      EXPECT_EQ(same.header("vary"), "Accept-Encoding");
      EXPECT_EQ(same.header("content-encoding"), "");
    }
    EXPECT_EQ(get(port(), path, "If-None-Match: " + small.header("etag") + "\r\n").status, 200)
        << "a client that does not admit gzip cannot use it";
    const Answer matched =
        get(port(), path, kGzip + ("If-Match: " + small.header("etag") + "\r\n"));
    EXPECT_EQ(matched.header("etag"), small.header("etag"));
    EXPECT_EQ(get(port(), path, kGzip + std::string("If-Match: \"other\"\r\n")).status, 412);
  }
}

TEST_F(Compression, OnlyClientsThatAdmitItReceiveIt) {
  start();
  for (const char* field :
       {"", "Accept-Encoding: \r\n", "Accept-Encoding: br\r\n", "Accept-Encoding: gzip;q=0\r\n",
        "Accept-Encoding: *;q=0\r\n", "Accept-Encoding: identity\r\n"}) {
    EXPECT_EQ(get(port(), "/v1/volumes", field).header("content-encoding"), "") << field;
  }
  for (const char* field : {"Accept-Encoding: gzip;q=0.1\r\n", "Accept-Encoding: *\r\n"}) {
    EXPECT_EQ(get(port(), "/v1/volumes", field).header("content-encoding"), "gzip") << field;
  }
}

TEST_F(Compression, CompressedDataAreNotCompressedAgain) {
  start();
  for (const std::string& path : {std::string("/v1/volumes/alpha/bootstrap"), content("header"),
                                  content("file"), content("chunks?isovalue=0..200&level=0"),
                                  content("chunks/" + place_of(alpha.chunks[0]))}) {
    const Answer answer = get(port(), path, kGzip);
    EXPECT_EQ(answer.status, 200) << path;
    EXPECT_EQ(answer.header("content-encoding"), "") << path;
  }
}

TEST(Compressors, KeepTheTextsThatWereCompressedLast) {
  Compressor compressor;
  const std::string small(1000, 'a'), text(10'000, 'a'), large(200'000, 'a');
  EXPECT_EQ(compressor.compress(small, "small"), nullptr);
  const auto first = compressor.compress(text, "text");
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(compressor.compress(text, "text"), first);
  EXPECT_EQ(compressor.find("text"), first);
  EXPECT_EQ(compressor.find("large"), std::nullopt);
  EXPECT_EQ(unzipped(*compressor.compress(large, "large")), large);
  for (int i = 0; i < 100; ++i) compressor.compress(text, std::to_string(i));
  EXPECT_NE(compressor.compress(text, "text"), first) << "the oldest texts are removed";
  std::string noise;
  for (uint32_t i = 0, x = 1; i < 50'000; ++i, x = x * 1664525 + 1013904223) {
    noise += static_cast<char>(x >> 24);
  }
  EXPECT_EQ(compressor.compress(noise, "noise"), nullptr) << "not smaller";
  EXPECT_EQ(compressor.find("noise"), nullptr) << "and is not compressed again";
}

TEST(Compressors, CompressOneLongTextAtATime) {
  Compressor compressor;
  std::string text;
  for (uint32_t i = 0, x = 1; i < 4'000'000; ++i, x = x * 1664525 + 1013904223) {
    text += static_cast<char>('a' + (x >> 28));
  }
  std::atomic<int> compressed{0}, plain{0};
  std::atomic<bool> go{false};
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&, i] {
      while (!go) std::this_thread::yield();
      ++(compressor.compress(text, "text " + std::to_string(i)) ? compressed : plain);
    });
  }
  go = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_GE(compressed, 1);
  EXPECT_EQ(compressed + plain, 8) << "none waits for another";
}

}  // namespace
}  // namespace isosplat::server::test
