// Compares the decompression without a library with zlib: the same bytes, and the same errors.
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <random>

#include "shared/import/codecs/checksums.h"
#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/codecs/inflate_stream.h"
#include "tests/native/temporary_folder.h"
#include "tests/native/volume_files.h"

namespace isosplat::import {
namespace {

using test::write_file;

std::string compressed(const std::string& text, int window_bits, int level, int strategy) {
  z_stream stream{};
  deflateInit2(&stream, level, Z_DEFLATED, window_bits, 8, strategy);
  std::string out(deflateBound(&stream, text.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// Noise, runs, and copies of earlier bytes at all distances.
std::string mixed_bytes(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::string bytes;
  while (bytes.size() < count) {
    const size_t length = 1 + random() % 300, back = 1 + random() % 40'000;
    const auto kind = random() % 4;
    for (size_t i = 0; i < length; ++i) {
      if (kind == 0 || bytes.size() < back) {
        bytes.push_back(static_cast<char>(random()));
      } else if (kind == 1) {
        bytes.push_back(bytes.back());
      } else if (kind == 2) {
        bytes.push_back(bytes[bytes.size() - back]);
      } else {
        bytes.push_back(static_cast<char>(random() % 5));
      }
    }
  }
  bytes.resize(count);
  return bytes;
}

struct Outcome {
  std::string bytes;
  Status status = Status::ok;
  std::string message;
};

Outcome expand(InflateStream& stream, size_t piece) {
  Outcome outcome;
  if (!stream.is_running()) {
    EXPECT_TRUE(stream.begin());
  }
  std::string out(piece, '\0');
  for (;;) {
    const auto made = stream.expand_some(std::as_writable_bytes(std::span(out)));
    if (!made) {
      outcome.status = made.error().status;
      outcome.message = made.error().message;
      return outcome;
    }
    outcome.bytes.append(out, 0, *made);
    if (*made < piece) return outcome;
  }
}

class Inflating : public ::testing::Test {
 protected:
  /// Expands a file with both.
  std::pair<Outcome, Outcome> expand_both(const std::string& content, Deflate kind, size_t piece) {
    const auto path = folder_.path() / "data";
    write_file(path, content);
    const auto file = ReadableFile::open(path);
    EXPECT_TRUE(file);
    return {expand(*make_zlib_stream(*file, 0, kind), piece),
            expand(*make_plain_inflate_stream(*file, 0, kind), piece)};
  }

  TemporaryFolder folder_;
};

TEST_F(Inflating, GivesTheBytesOfEveryKindOfBlockAndContainer) {
  for (const size_t count :
       {size_t{0}, size_t{1}, size_t{300}, size_t{70'000}, size_t{1'500'000}}) {
    const std::string data = mixed_bytes(count, static_cast<uint32_t>(count));
    for (const int level : {0, 1, 6, 9}) {
      for (const int strategy : {Z_DEFAULT_STRATEGY, Z_HUFFMAN_ONLY, Z_RLE, Z_FIXED}) {
        for (const int window : {31, 15, 9, 25, -15}) {
          const auto content = compressed(data, window, level, strategy);
          const auto kind = window < 0 ? Deflate::raw : Deflate::gzip_or_zlib;
          const auto [zlib, plain] = expand_both(content, kind, 100'001);
          ASSERT_EQ(plain.status, Status::ok)
              << plain.message << count << " " << level << " " << strategy << " " << window;
          ASSERT_TRUE(plain.bytes == data) << count << " " << level << " " << strategy;
          ASSERT_TRUE(zlib.bytes == data);
        }
      }
    }
  }
}

TEST_F(Inflating, ReadsMembersUntilOtherBytesFollow) {
  const std::string a = mixed_bytes(50'000, 1), b = mixed_bytes(90'000, 2);
  const std::string two = compressed(a, 31, 6, 0) + compressed(b, 31, 1, 0);
  for (const std::string& after :
       {std::string(), std::string("x"), std::string("\x1f"), std::string("\x1f\x8b\x08"),
        std::string(5000, '\0'), std::string("\x1f\x8b\x08\0\0\0\0\0\0\xff\xff\xff", 12)}) {
    const auto [zlib, plain] = expand_both(two + after, Deflate::gzip_or_zlib, 7777);
    EXPECT_EQ(plain.status, zlib.status) << plain.message << " / " << zlib.message;
    EXPECT_TRUE(plain.bytes == a + b);
    EXPECT_TRUE(zlib.bytes == a + b);
  }
}

TEST_F(Inflating, ReportsCutAndDamagedDataAsZlibDoes) {
  std::mt19937 random(3);
  const std::string data = mixed_bytes(20'000, 4);
  int same_words = 0, damaged = 0;
  for (int i = 0; i < 3000; ++i) {
    const int window = std::array{31, 15, -15}[random() % 3];
    const auto kind = window < 0 ? Deflate::raw : Deflate::gzip_or_zlib;
    std::string content = compressed(data.substr(0, 100 + random() % 19'000), window,
                                     1 + static_cast<int>(random() % 9),
                                     std::array{Z_DEFAULT_STRATEGY, Z_FIXED}[random() % 2]);
    if (random() % 4 == 0) {
      content.resize(random() % content.size() + 1);
    } else {
      for (auto flips = 1 + random() % 3; flips > 0; --flips) {
        content[random() % content.size()] ^= static_cast<char>(1 << random() % 8);
      }
    }
    const auto [zlib, plain] = expand_both(content, kind, 1 + random() % 5000);
    ASSERT_EQ(plain.status, zlib.status) << i << ": " << plain.message << " / " << zlib.message;
    const size_t common = std::min(plain.bytes.size(), zlib.bytes.size());
    ASSERT_TRUE(plain.bytes.compare(0, common, zlib.bytes, 0, common) == 0) << i;
    if (zlib.status == Status::ok) {
      ASSERT_TRUE(plain.bytes == zlib.bytes) << i;
    }
    if (zlib.status != Status::malformed_volume) continue;
    ++damaged;
    const auto reason = [](const std::string& message) {
      return message.substr(message.find('('), message.find(')') - message.find('('));
    };
    if (reason(plain.message) == reason(zlib.message)) ++same_words;
  }
  EXPECT_GT(damaged, 1000);
  EXPECT_EQ(same_words, damaged);
}

TEST_F(Inflating, ContinuesAtAccessPoints) {
  const std::string data = mixed_bytes(6'000'000, 5);
  for (const int window : {31, 15, -15}) {
    const auto path = folder_.path() / "data";
    write_file(path, "abc" + compressed(data, window, 6, 0));
    const auto file = ReadableFile::open(path);
    const auto kind = window < 0 ? Deflate::raw : Deflate::gzip_or_zlib;
    const auto first = make_plain_inflate_stream(*file, 3, kind);
    ASSERT_TRUE(first->begin());
    AccessPoints points;
    std::string out(data.size(), '\0');
    ASSERT_EQ(first->expand_some(std::as_writable_bytes(std::span(out)), &points), data.size());
    ASSERT_GE(points.count(), 4u);
    for (uint64_t place = 1 << 20; place < data.size(); place += 1'500'000) {
      const AccessPoint* const point = points.before(place);
      if (!point) continue;
      for (const auto& again :
           {make_plain_inflate_stream(*file, 3, kind), make_zlib_stream(*file, 3, kind)}) {
        ASSERT_TRUE(again->begin_at(*point));
        const auto rest = expand(*again, 65'536);
        EXPECT_EQ(rest.status, Status::ok) << rest.message;
        EXPECT_TRUE(rest.bytes == data.substr(point->output)) << place;
      }
    }
  }
}

TEST(ImportChecksums, AreZlibs) {
  const std::string data = mixed_bytes(100'000, 6);
  const auto bytes = std::span(reinterpret_cast<const uint8_t*>(data.data()), data.size());
  for (const size_t count : {0, 1, 7, 8, 9, 5552, 5553, 99'999}) {
    const auto* from = reinterpret_cast<const Bytef*>(data.data());
    const auto size = static_cast<uInt>(count);
    EXPECT_EQ(import::crc32(0, bytes.first(count)), ::crc32(0, from, size));
    EXPECT_EQ(import::adler32(1, bytes.first(count)), ::adler32(1, from, size));
  }
}

}  // namespace
}  // namespace isosplat::import
