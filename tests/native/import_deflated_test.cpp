// Reads deflated data at any offset, from access points, and compares them with the original data.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <random>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/codecs/access_points.h"
#include "shared/import/codecs/deflated_reader.h"
#include "tests/native/temporary_folder.h"
#include "tests/native/volume_files.h"

namespace isosplat::import {
namespace {

using test::deflated;
using test::write_file;

/// Bytes that deflate in many blocks, with matches across their borders.
std::string compressible_bytes(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::string bytes;
  while (bytes.size() < count) {
    const size_t back = 1 + random() % 30'000, length = 20 + random() % 200;
    if (bytes.size() > back && random() % 3 == 0) {
      for (size_t i = 0; i < length; ++i) bytes.push_back(bytes[bytes.size() - back]);
    } else {
      for (size_t i = 0; i < length; ++i) bytes.push_back(static_cast<char>(random() >> 28));
    }
  }
  bytes.resize(count);
  return bytes;
}

std::unique_ptr<ByteReader> open(const std::filesystem::path& path, uint64_t start = 0,
                                 Deflate kind = Deflate::gzip_or_zlib) {
  auto reader = open_deflated(path, start, kind);
  EXPECT_TRUE(reader);
  return std::move(*reader);
}

/// Reads a range and compares it. Returns the error's status, or ok.
Status read_and_compare(ByteReader& reader, const std::string& data, size_t offset, size_t count) {
  std::string out(count, '?');
  const auto read = reader.read(offset, std::as_writable_bytes(std::span(out)));
  if (!read) return read.error().status;
  EXPECT_TRUE(data.compare(offset, count, out) == 0) << offset << " " << count;
  return Status::ok;
}

void read_at_random(ByteReader& reader, const std::string& data) {
  std::mt19937 random(9);
  for (int i = 0; i < 40; ++i) {
    const size_t offset = random() % data.size();
    const size_t count = std::min<size_t>(1 + random() % 70'000, data.size() - offset);
    EXPECT_EQ(read_and_compare(reader, data, offset, count), Status::ok);
  }
  // Read across the offset up to which the data have been decompressed before.
  EXPECT_EQ(read_and_compare(reader, data, 0, data.size()), Status::ok);
  EXPECT_EQ(read_and_compare(reader, data, data.size() - 1, 1), Status::ok);
  EXPECT_EQ(reader.available_bytes(), data.size());
  EXPECT_EQ(reader.count_after(data.size() - 5, 100).value_or(0), 5u);
  std::byte one;
  EXPECT_EQ(reader.read(data.size(), std::span(&one, 1)).error().status, Status::truncated);
  EXPECT_EQ(read_and_compare(reader, data, data.size() / 2 + 1, 1001), Status::ok);
}

TEST(ImportDeflated, RandomReadsGiveTheBytesOfEachContainer) {
  const TemporaryFolder folder;
  const std::string data = compressible_bytes(5'000'003, 1);
  for (const int window_bits : {31, 15, -15}) {
    const auto path = folder.path() / "data.gz";
    write_file(path, "0123456" + deflated(data, window_bits));
    const Deflate kind = window_bits < 0 ? Deflate::raw : Deflate::gzip_or_zlib;
    const auto reader = open(path, 7, kind);
    EXPECT_GE(reader->resident_bytes(), 4 * AccessPoints::kWindowBytes);
    EXPECT_LE(reader->resident_bytes(), uint64_t{8} << 20);
    read_at_random(*reader, data);
    const auto backwards = open(path, 7, kind);
    for (size_t end = data.size(); end > 0;) {
      const size_t begin = end - std::min<size_t>(end, 333'333);
      EXPECT_EQ(read_and_compare(*backwards, data, begin, end - begin), Status::ok);
      end = begin;
    }
  }
}

TEST(ImportDeflated, RandomReadsCrossMembers) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "members.gz";
  // Members of a few bytes, of one block each, and longer than the distance between access points.
  std::string data, file;
  uint32_t seed = 0;
  for (const size_t bytes : {1u, 2'500'000u, 60'000u, 60'000u, 5u, 1'200'001u, 900'000u, 65'536u}) {
    for (int times = 0; times < (bytes == 65'536u ? 30 : 1); ++times) {
      const std::string member = compressible_bytes(bytes, ++seed);
      data += member;
      file += deflated(member, seed % 3 == 0 ? 15 : 31);
    }
  }
  for (const char* surplus : {"", "no gzip data"}) {
    write_file(path, file + surplus);
    const auto reader = open(path);
    read_at_random(*reader, data);
  }
}

/// A gzip member in which the deflated data of `sound` bytes are followed by an invalid block.
std::string damaged_after(const std::string& data, size_t sound) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 31, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, data.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(sound);
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FULL_FLUSH);  // the next block begins at a byte boundary
  const size_t damage = stream.total_out;
  stream.avail_in = static_cast<uInt>(data.size() - sound);
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  out[damage] = 7;  // the last block, of type 3, which does not exist
  return out;
}

TEST(ImportDeflated, BytesBeforeDamageCanStillBeRead) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "damaged.gz";
  constexpr size_t kSound = 3'500'000;
  const std::string data = compressible_bytes(5'000'000, 2), whole = deflated(data);
  const std::string damaged = damaged_after(data, kSound);
  const std::string cut = whole.substr(0, whole.size() * 7 / 10);
  for (const std::string& file : {damaged, cut}) {
    write_file(path, file);
    const auto reader = open(path);
    std::string all(data.size(), '?');
    for (int times = 0; times < 2; ++times) {  // the second read has the same error
      const auto read = reader->read(0, std::as_writable_bytes(std::span(all)));
      ASSERT_FALSE(read);
      EXPECT_EQ(read.error().status, file == cut ? Status::truncated : Status::malformed_volume);
      for (const size_t offset : {3'000'001u, 1'100'000u, 5u, 2'222'222u}) {
        EXPECT_EQ(read_and_compare(*reader, data, offset, 100'000), Status::ok);
      }
    }
    const uint64_t available = reader->available_bytes();
    if (file == damaged) {
      EXPECT_EQ(available, kSound);
    } else {
      EXPECT_GT(available, 3'100'001u);
      EXPECT_LT(available, 4'000'000u);
    }
  }
  std::string checksum = whole;
  checksum[whole.size() - 6] ^= 1;
  // The checksum is verified at the end, even if other parts were read in between.
  write_file(path, checksum);
  const auto reader = open(path);
  EXPECT_EQ(read_and_compare(*reader, data, 4'000'000, 1000), Status::ok);
  EXPECT_EQ(read_and_compare(*reader, data, 2'000'000, 1000), Status::ok);
  EXPECT_EQ(read_and_compare(*reader, data, 4'990'000, 1000), Status::ok);
  EXPECT_EQ(reader->count_after(data.size(), 1).error().status, Status::malformed_volume);
}

TEST(ImportDeflated, AccessPointsAreLimitedInNumber) {
  AccessPoints points;
  size_t added = 0;
  for (uint64_t output = 0; output < uint64_t{4000} << 20; output += 300'000) {
    if (!points.wants(output)) continue;
    points.add({output, output / 2, 0, 8, std::vector<std::byte>(1)});
    ++added;
    // The nearest access point is never after the offset, and at most twice the current distance
    // before it.
    ASSERT_EQ(points.before(output)->output, output);
  }
  EXPECT_GT(added, AccessPoints::kMaxPoints);
  EXPECT_LE(points.count(), AccessPoints::kMaxPoints);
  EXPECT_EQ(points.before(1000), nullptr);
  for (uint64_t output = uint64_t{40} << 20; output < uint64_t{3900} << 20; output += 7 << 20) {
    const AccessPoint* point = points.before(output);
    ASSERT_TRUE(point);
    EXPECT_LE(point->output, output);
    EXPECT_GT(point->output + (uint64_t{40} << 20), output);
  }
  EXPECT_EQ(AccessPoints::max_bytes(uint64_t{1} << 40), uint64_t{8} << 20);
  EXPECT_EQ(AccessPoints::max_bytes(1000), 0u);
}

}  // namespace
}  // namespace isosplat::import
