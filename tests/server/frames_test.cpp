// Several chunks in one response: which ones, in what order, of what size, and what happens to
// broken ones.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "server/http/streams.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

struct Frame {
  uint32_t bytes, status, level, x, y, z, band, cells, begin, end, checksum, reserved;
  std::string chunk;
};

/// Parses frames as HTTP.md specifies them.
std::vector<Frame> frames_of(const std::string& body) {
  std::vector<Frame> frames;
  for (size_t at = 0; at < body.size();) {
    uint32_t field[12];
    if (body.size() - at < sizeof field) throw std::runtime_error("half a frame");
    for (size_t i = 0; i < 12; ++i) {
      field[i] = 0;
      for (size_t byte = 4; byte-- > 0;) {
        field[i] = field[i] << 8 | static_cast<unsigned char>(body[at + i * 4 + byte]);
      }
    }
    at += sizeof field;
    const size_t padded = (field[0] + 15) / 16 * 16;
    if (body.size() - at < padded) throw std::runtime_error("half a chunk");
    frames.push_back({field[0], field[1], field[2], field[3], field[4], field[5], field[6],
                      field[7], field[8], field[9], field[10], field[11],
                      body.substr(at, field[0])});
    for (size_t i = field[0]; i < padded; ++i) {
      if (body[at + i] != 0) throw std::runtime_error("padding");
    }
    at += padded;
  }
  return frames;
}

void append(std::string& list, const std::string& item) {
  if (!list.empty()) list += ',';
  list += item;
}

class Frames : public ServerTest {
 protected:
  void expect_frames(const Answer& answer, const std::vector<const KnownChunk*>& expected) {
    ASSERT_EQ(answer.status, 200) << answer.body;
    EXPECT_TRUE(answer.complete);
    EXPECT_EQ(answer.header("content-type"), "application/vnd.isosplat.frames");
    EXPECT_EQ(answer.header("cache-control"), "public, max-age=31536000, immutable");
    EXPECT_EQ(answer.header("x-isosplat-chunks"), std::to_string(expected.size()));
    const std::vector<Frame> frames = frames_of(answer.body);
    ASSERT_EQ(frames.size(), expected.size());
    for (size_t i = 0; i < frames.size(); ++i) {
      const Frame& frame = frames[i];
      const KnownChunk& chunk = *expected[i];
      EXPECT_EQ(frame.status, 0u);
      EXPECT_EQ(frame.chunk, text_of(chunk.bytes));
      EXPECT_EQ(frame.level, chunk.block.level);
      EXPECT_EQ((Index3{static_cast<int32_t>(frame.x), static_cast<int32_t>(frame.y),
                        static_cast<int32_t>(frame.z)}),
                chunk.block.index);
      EXPECT_EQ(frame.band, chunk.band);
      EXPECT_EQ(frame.cells, chunk.cells);
      EXPECT_EQ(frame.begin, chunk.band_begin);
      EXPECT_EQ(frame.end, chunk.band_end);
      EXPECT_EQ(frame.reserved, 0u);
    }
  }

  float quantized_isovalue(double isovalue) const {
    return alpha.info.mapping.quantized_isovalue(isovalue);
  }

  /// Replaces the store of alpha by one that differs in one byte of the chunk.
  void corrupt(const KnownChunk& chunk) {
    const std::string file = text_of(alpha.file);
    const size_t at = file.find(text_of(chunk.bytes));
    ASSERT_NE(at, std::string::npos);
    std::string changed = file;
    changed[at + chunk.bytes.size() / 2] = static_cast<char>(~changed[at + chunk.bytes.size() / 2]);
    write_file(folder.path() / "alpha.isosplat", changed);
  }
};

TEST_F(Frames, RangeQueriesMatchBruteForce) {
  start();
  Client client(port());
  for (uint32_t level = 0; level < alpha.info.levels; ++level) {
    for (const auto& [low, high] : {std::pair{-200.0, 200.0},
                                    {-100.0, -100.0},
                                    {-70.0, -60.5},
                                    {-65.25, -65.25},
                                    {-64.0, -64.0},
                                    {0.0, 5.0},
                                    {90.0, 91.0}}) {
      const std::string isovalue =
          low == high ? std::to_string(low) : std::to_string(low) + ".." + std::to_string(high);
      const Answer answer = client.request(
          "GET", content("chunks?isovalue=" + isovalue + "&level=" + std::to_string(level)));
      expect_frames(answer,
                    alpha.meeting(level, quantized_isovalue(low), quantized_isovalue(high)));
    }
  }
}

TEST_F(Frames, BlocksInTheRequestedOrder) {
  start();
  const auto all = alpha.meeting(0, quantized_isovalue(-90), quantized_isovalue(-50));
  std::vector<Index3> blocks;
  for (const KnownChunk* chunk : all) {
    if (blocks.empty() || !(blocks.back() == chunk->block.index)) {
      blocks.push_back(chunk->block.index);
    }
  }
  std::shuffle(blocks.begin(), blocks.end(), std::mt19937(7));
  std::string list;
  std::vector<const KnownChunk*> expected;
  for (const Index3& block : blocks) {
    append(list,
           std::to_string(block.x) + "." + std::to_string(block.y) + "." + std::to_string(block.z));
    for (const KnownChunk* chunk : all) {
      if (chunk->block.index == block) expected.push_back(chunk);
    }
  }
  expect_frames(get(port(), content("chunks?isovalue=-90..-50&level=0&blocks=" + list)), expected);
  // Parameters in any order, and as encodeURIComponent writes them.
  std::string escaped = list;
  for (size_t at; (at = escaped.find(',')) != std::string::npos;) escaped.replace(at, 1, "%2C");
  expect_frames(get(port(), content("chunks?blocks=" + escaped + "&level=0&isovalue=-90..-50")),
                expected);
}

TEST_F(Frames, BatchInTheRequestedOrder) {
  start();
  std::vector<const KnownChunk*> expected;
  for (const KnownChunk& chunk : alpha.chunks) expected.push_back(&chunk);
  std::shuffle(expected.begin(), expected.end(), std::mt19937(5));
  ASSERT_GE(expected.size(), 60u);
  expected.resize(60);
  expected.push_back(expected.front());  // a chunk that is requested twice is sent twice
  std::string list;
  for (const KnownChunk* chunk : expected) append(list, place_of(*chunk));
  const Answer answer = get(port(), content("batch?chunks=" + list));
  expect_frames(answer, expected);
  EXPECT_EQ(get(port(), content("batch?chunks=" + list),
                "If-None-Match: " + answer.header("etag") + "\r\n")
                .status,
            304);
  const Answer header = Client(port()).request("HEAD", content("batch?chunks=" + list));
  EXPECT_EQ(header.header("content-length"), std::to_string(answer.body.size()));
}

TEST_F(Frames, InvalidQueriesAreRefused) {
  start();
  for (const char* query : {"chunks",
                            "chunks?",
                            "chunks?level=0",
                            "chunks?isovalue=1",
                            "chunks?isovalue=2..1&level=0",
                            "chunks?isovalue=nan&level=0",
                            "chunks?isovalue=1e999&level=0",
                            "chunks?isovalue=&level=0",
                            "chunks?isovalue=1&level=",
                            "chunks?isovalue=1&level=-1",
                            "chunks?isovalue=1&level=0&x=1",
                            "chunks?isovalue=1&isovalue=2&level=0",
                            "chunks?isovalue=1&level=0&blocks=",
                            "chunks?isovalue=1&level=0&blocks=0.0",
                            "batch",
                            "batch?chunks=",
                            "batch?chunks=0/0.0.0",
                            "batch?chunks=0/0.0.0/0&chunks=0/0.0.0/0",
                            "batch?chunks=0/0.0.0/0,",
                            "batch?other=1"}) {
    EXPECT_EQ(get(port(), content(query)).status, 400) << query;
  }
  for (const char* query :
       {"chunks?isovalue=1&level=31", "chunks?isovalue=1&level=0&blocks=0.0.0,99.0.0",
        "batch?chunks=0/99.0.0/0", "batch?chunks=0/0.0.0/999", "batch?chunks=31/0.0.0/0"}) {
    EXPECT_EQ(get(port(), content(query)).status, 404) << query;
  }
}

TEST_F(Frames, MoreThanTheLimitIsRefusedBeforeItIsRead) {
  options.limits.query_bytes = 20'000;
  start();
  const Answer answer = get(port(), content("chunks?isovalue=-200..200&level=0"));
  EXPECT_EQ(answer.status, 413);
  EXPECT_NE(answer.body.find("20000 bytes"), std::string::npos) << answer.body;
  EXPECT_NE(answer.body.find("found at least 2"), std::string::npos) << answer.body;
  std::string list;
  uint64_t bytes = 0;
  for (size_t i = 0; bytes <= 20'000; ++i) {
    bytes += alpha.chunks[i].bytes.size();
    append(list, place_of(alpha.chunks[i]));
  }
  EXPECT_EQ(get(port(), content("batch?chunks=" + list)).status, 413);
  EXPECT_EQ(get(port(), content("batch?chunks=" + list.substr(0, list.rfind(',')))).status, 200);
}

TEST_F(Frames, TooManyChunksAreRefused) {
  options.limits.query_chunks = 3;
  start();
  EXPECT_EQ(get(port(), content("chunks?isovalue=-200..200&level=0")).status, 413);
  EXPECT_EQ(get(port(), content("batch?chunks=0/0.0.0/0,0/0.0.0/0,0/0.0.0/0,0/0.0.0/0")).status,
            get(port(), content("chunks/0/0.0.0/0")).status == 200 ? 413 : 404);
}

TEST_F(Frames, ALargeDirectoryIsNotSearchedToItsEnd) {
  const StoreReader reader = *StoreReader::open(alpha.file);
  const uint32_t bytes = reader.pages()[*reader.page_of({0, {0, 0, 0}})].bytes;
  const std::string chunk = place_of(alpha.chunks[0]), other = place_of(alpha.chunks.back());
  ASSERT_NE(chunk[0], other[0]) << "of two levels, and so of two pages";
  options.limits.query_directory_bytes = bytes;
  start();
  EXPECT_EQ(get(port(), content("chunks?isovalue=-200..200&level=0")).status, 200);
  EXPECT_EQ(get(port(), content("batch?chunks=" + chunk + "," + chunk)).status, 200);
  const Answer answer = get(port(), content("batch?chunks=" + chunk + "," + other));
  EXPECT_EQ(answer.status, 413);
  EXPECT_NE(answer.body.find("directory pages"), std::string::npos) << answer.body;
  server.reset();
  options.limits.query_directory_bytes = bytes - 1;
  start();
  EXPECT_EQ(get(port(), content("chunks?isovalue=-200..200&level=0")).status, 413);
  EXPECT_EQ(get(port(), content("chunks?isovalue=-200..200&level=0&blocks=0.0.0")).status, 413);
  EXPECT_EQ(get(port(), content("batch?chunks=" + chunk)).status, 413);
}

TEST_F(Frames, ADamagedChunkIsAnError) {
  const KnownChunk* broken = nullptr;
  const auto chunks = alpha.meeting(0, quantized_isovalue(-200), quantized_isovalue(200));
  for (const KnownChunk* chunk : chunks) {
    if (chunk->bytes.size() > 100) broken = chunk;
  }
  corrupt(*broken);
  start();
  const Answer single = get(port(), content("chunks/" + place_of(*broken)));
  EXPECT_EQ(single.status, 500);
  EXPECT_EQ(single.header("cache-control"), "no-store");
  EXPECT_NE(single.body.find("checksum_mismatch"), std::string::npos) << single.body;
  EXPECT_NE(single.body.find(place_of(*broken)), std::string::npos) << single.body;
  EXPECT_TRUE(will_log(place_of(*broken)));

  const KnownChunk& good = *chunks.front();
  EXPECT_EQ(get(port(), content("chunks/" + place_of(good))).body, text_of(good.bytes));
  Client client(port());
  const Answer batch = client.request("GET", content("batch?chunks=" + place_of(good) + "," +
                                                     place_of(*broken) + "," + place_of(good)));
  EXPECT_EQ(batch.status, 200);
  EXPECT_FALSE(batch.complete) << "caches do not keep an incomplete response";
  const std::vector<Frame> frames = frames_of(batch.body);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].chunk, text_of(good.bytes));
  EXPECT_EQ(frames[1].status, static_cast<uint32_t>(Status::checksum_mismatch));
  EXPECT_EQ(frames[1].bytes, 0u);
  EXPECT_EQ(frames[1].band, broken->band);
}

TEST_F(Frames, ADamagedPageIsAnError) {
  const Result<StoreReader> reader = StoreReader::open(alpha.file);
  ASSERT_TRUE(reader);
  std::vector<std::byte> file = alpha.file;
  uint32_t fine_page = 0;
  ASSERT_TRUE(reader->page_of({0, {0, 0, 0}}));
  fine_page = *reader->page_of({0, {0, 0, 0}});
  file[reader->pages()[fine_page].offset + 9] ^= std::byte{1};
  write_file(folder.path() / "alpha.isosplat", file);
  start();
  for (const std::string& rest :
       {"pages/" + std::to_string(fine_page), std::string("chunks/0/0.0.0/0"),
        std::string("chunks?isovalue=-200..200&level=0"), std::string("batch?chunks=0/0.0.0/0")}) {
    const Answer answer = get(port(), content(rest));
    EXPECT_EQ(answer.status, 500) << rest;
    EXPECT_NE(answer.body.find("checksum"), std::string::npos) << answer.body;
  }
}

TEST_F(Frames, LargeChunksAndASmallDirectory) {
  const KnownStore beta = make_store(9, {130, 130, 130}, 400'000);
  write_file(folder.path() / "beta.isosplat", beta.file);
  options.limits.directory_bytes = 1;  // pages are dropped before each load
  start();
  const Answer answer =
      get(port(), "/v1/volumes/beta/" + beta.content + "/chunks?isovalue=-200..200&level=0");
  expect_frames(answer, beta.meeting(0, -1000, 1000));
  EXPECT_GT(answer.body.size(), 1'000'000u);
  Client client(port());
  for (const KnownChunk& chunk : beta.chunks) {
    const Answer single =
        client.request("GET", "/v1/volumes/beta/" + beta.content + "/chunks/" + place_of(chunk));
    ASSERT_EQ(single.body, text_of(chunk.bytes));
  }
}

}  // namespace
}  // namespace isosplat::server::test
