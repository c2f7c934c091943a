// Disks that fail: each route returns its defined error, the connection continues or is closed as
// HTTP.md states, and other stores are served.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/server/faulty_disk.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

/// Two stores on a damaged disk. The parameter is the name of the one that is read: the system has
/// the bytes of "damaged-disk" in memory, and those of "slow-damaged-disk" are read by the threads
/// for disks.
class DiskErrors : public ServerTest, public ::testing::WithParamInterface<const char*> {
 protected:
  DiskErrors() {
    write_file(folder.path() / (name + ".isosplat"), damaged.file);
    // Memory for two bodies of one address, so that the test fails if the memory of bodies is not
    // released.
    options.limits.bytes_in_flight = 1 << 20;
    options.threads = 1;
  }
  ~DiskErrors() override { first_bad_byte() = kNoBadBytes; }

  std::string target(const std::string& rest) const {
    return "/v1/volumes/" + name + "/" + damaged.content + "/" + rest;
  }
  const KnownChunk& first_chunk() const {
    return *std::ranges::find_if(damaged.chunks, [](const auto& each) { return each.cells > 0; });
  }
  uint64_t offset_of(const KnownChunk& chunk) const {
    const auto found = std::search(damaged.file.begin(), damaged.file.end(), chunk.bytes.begin(),
                                   chunk.bytes.end());
    return static_cast<uint64_t>(found - damaged.file.begin());
  }
  /// The other store is served, on a connection that must have stayed open.
  void expect_others_served(Client& client) {
    const Answer answer = client.request("GET", content("file"));
    EXPECT_EQ(answer.status, 200) << answer.body;
    EXPECT_TRUE(answer.body == text_of(alpha.file));
  }
  void expect_others_served() {
    Client client(port());
    expect_others_served(client);
  }
  bool has_metric(const std::string& line) const {
    return get(port(), "/metrics").body.find("\n" + line + "\n") != std::string::npos;
  }

  const std::string name = GetParam();
  const KnownStore damaged = make_store(7);
};

uint32_t u32_at(std::string_view text, size_t offset) {
  uint32_t value = 0;
  std::memcpy(&value, text.data() + offset, sizeof value);
  return value;
}

TEST_P(DiskErrors, AHeaderThatCannotBeReadIsAnErrorUntilItCan) {
  first_bad_byte() = 0;
  start();
  Client client(port());
  for (const char* const rest : {"", "/bootstrap"}) {
    const Answer answer = client.request("GET", "/v1/volumes/" + name + rest);
    EXPECT_EQ(answer.status, 500);
    EXPECT_NE(answer.body.find(R"("status":"io_error")"), std::string::npos) << answer.body;
    EXPECT_NE(answer.body.find(name + ".isosplat: cannot be read"), std::string::npos)
        << answer.body;
    EXPECT_EQ(answer.body.find(folder.path().string()), std::string::npos) << "shows a folder";
    EXPECT_EQ(answer.header("cache-control"), "no-store");
  }
  EXPECT_NE(client.request("GET", "/v1/volumes").body.find("\"error\":{\"status\":\"io_error\""),
            std::string::npos);
  EXPECT_TRUE(eventually([&] {
    return client.request("GET", "/healthz").body ==
           "{\"status\":\"ok\",\"volumes\":1,\"broken\":1}\n";
  }));
  EXPECT_EQ(client.request("GET", "/readyz").status, 200);
  expect_others_served(client);
  first_bad_byte() = kNoBadBytes;
  EXPECT_EQ(client.request("GET", "/v1/volumes/" + name).status, 200);
  EXPECT_TRUE(eventually([&] {
    return client.request("GET", "/healthz").body ==
           "{\"status\":\"ok\",\"volumes\":2,\"broken\":0}\n";
  }));
}

TEST_P(DiskErrors, EveryRouteOfAnOpenStoreHasItsError) {
  start();
  Client client(port());
  const Answer whole = client.request("GET", "/v1/volumes/" + name);
  EXPECT_EQ(whole.status, 200);
  first_bad_byte() = 0;
  const std::string chunk = place_of(first_chunk());
  const double isovalue =
      damaged.info.mapping.offset +
      damaged.info.mapping.scale * static_cast<double>(first_chunk().band_begin);
  const std::string query = "?isovalue=" + std::to_string(isovalue) +
                            "&level=" + std::to_string(first_chunk().block.level);
  int faults = 0;
  for (const std::string& rest :
       {std::string("pages/0"), "chunks/" + chunk, "chunks" + query, "batch?chunks=" + chunk,
        "isovalues" + query, "samples" + query}) {
    for (const char* const method : {"GET", "HEAD"}) {
      const Answer answer = client.request(method, target(rest));
      EXPECT_EQ(answer.status, 500) << method << " " << rest;
      EXPECT_EQ(answer.header("cache-control"), "no-store") << rest;
      EXPECT_EQ(answer.header("etag"), "") << rest;
      const bool is_named = answer.body.find(R"("status":"io_error")") != std::string::npos;
      EXPECT_EQ(is_named, method == std::string("GET")) << answer.body;
      ++faults;
    }
    expect_others_served(client);
  }
  EXPECT_TRUE(has_metric("isosplat_faults_total " + std::to_string(faults)));
  // Bytes in memory are served as before. Once the disk works again, everything is served.
  EXPECT_EQ(client.request("GET", "/v1/volumes/" + name).body, whole.body);
  EXPECT_EQ(client.request("GET", target("header")).status, 200);
  first_bad_byte() = kNoBadBytes;
  EXPECT_EQ(client.request("GET", target("chunks/" + chunk)).body, text_of(first_chunk().bytes));
  EXPECT_TRUE(client.request("GET", target("file")).body == text_of(damaged.file));
}

TEST_P(DiskErrors, AStreamedResponseIsAnErrorIfItsFirstReadFails) {
  start();
  Client client(port());
  const std::string everything = "?isovalue=-1e9..1e9&level=0";
  const std::string chunk = place_of(first_chunk());
  const std::vector<std::string> paths = {target("file"), "/v1/volumes/" + name + "/bootstrap",
                                          target("chunks" + everything),
                                          target("batch?chunks=" + chunk)};
  std::vector<std::string> bodies;
  for (const std::string& path : paths) bodies.push_back(client.request("GET", path).body);
  const std::string before = get(port(), "/metrics").body;
  EXPECT_NE(before.find("\nisosplat_faults_total 0\n"), std::string::npos);
  first_bad_byte() = 0;
  int faults = 0;
  for (const std::string& path : paths) {
    for (const char* const fields : {"", "Range: bytes=100-200\r\n"}) {
      const Answer answer = client.request("GET", path, fields);
      EXPECT_EQ(answer.status, 500) << path;
      EXPECT_TRUE(answer.complete);
      EXPECT_NE(answer.body.find(R"("status":"io_error")"), std::string::npos) << answer.body;
      EXPECT_EQ(answer.body.find(folder.path().string()), std::string::npos) << "shows a folder";
      EXPECT_EQ(answer.header("cache-control"), "no-store");
      EXPECT_EQ(answer.header("content-type"), "application/json");
      EXPECT_EQ(answer.header("x-content-type-options"), "nosniff");
      for (const char* const absent :
           {"etag", "content-range", "accept-ranges", "x-isosplat-chunks"}) {
        EXPECT_EQ(answer.header(absent), "") << path;
      }
      ++faults;
      expect_others_served(client);
    }
    // HEAD reads nothing of the body.
    EXPECT_EQ(client.request("HEAD", path).status, 200) << path;
  }
  EXPECT_TRUE(has_metric("isosplat_faults_total " + std::to_string(faults)));
  first_bad_byte() = kNoBadBytes;
  for (size_t i = 0; i < paths.size(); ++i) {
    EXPECT_TRUE(client.request("GET", paths[i]).body == bodies[i]) << paths[i];
  }
}

TEST_P(DiskErrors, AFileIsCutWhereItCannotBeRead) {
  start();
  constexpr uint64_t kPiece = 64 * 1024;
  ASSERT_GT(damaged.file.size(), 2 * kPiece);
  EXPECT_EQ(get(port(), "/v1/volumes/" + name).status, 200);
  first_bad_byte() = kPiece + 1000;
  for (int i = 0; i < 4; ++i) {
    Client client(port());
    const Answer answer = client.request("GET", target("file"));
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.header("content-length"), std::to_string(damaged.file.size()));
    EXPECT_TRUE(answer.body == text_of(damaged.file).substr(0, kPiece));
    EXPECT_TRUE(client.is_closed());
    expect_others_served();
  }
  // A part that can be read is complete, and the connection stays.
  Client other(port());
  EXPECT_TRUE(other.request("GET", target("file"), "Range: bytes=0-65535\r\n").body ==
              text_of(damaged.file).substr(0, kPiece));
  expect_others_served(other);
}

TEST_P(DiskErrors, FramesEndWithThatOfTheChunkThatCannotBeRead) {
  start();
  const std::string frames = target("chunks?isovalue=-1e9..1e9&level=0");
  const Answer whole = get(port(), frames);
  ASSERT_EQ(whole.status, 200);
  ASSERT_TRUE(whole.complete);
  std::vector<const KnownChunk*> chunks = damaged.meeting(0, -1e9F, 1e9F);
  ASSERT_GT(chunks.size(), 4u);
  const size_t last = chunks.size() / 2;
  first_bad_byte() = offset_of(*chunks[last]);
  Client client(port());
  const Answer answer = client.request("GET", frames);
  EXPECT_EQ(answer.status, 200);
  EXPECT_FALSE(answer.complete);
  EXPECT_TRUE(client.is_closed());
  constexpr size_t kFrameHeader = 48;
  size_t at = 0;
  for (size_t i = 0; i < last; ++i) {
    ASSERT_LE(at + kFrameHeader, answer.body.size());
    const size_t bytes = u32_at(answer.body, at);
    EXPECT_EQ(u32_at(answer.body, at + 4), 0u);
    EXPECT_TRUE(answer.body.substr(at + kFrameHeader, bytes) == text_of(chunks[i]->bytes));
    at += kFrameHeader + (bytes + 15) / 16 * 16;
  }
  ASSERT_EQ(answer.body.size(), at + kFrameHeader);
  EXPECT_EQ(u32_at(answer.body, at), 0u);
  EXPECT_EQ(u32_at(answer.body, at + 4), static_cast<uint32_t>(Status::io_error));
  expect_others_served();
  EXPECT_EQ(get(port(), target("chunks/" + place_of(*chunks[last]))).status, 500);
  first_bad_byte() = kNoBadBytes;
  EXPECT_TRUE(get(port(), frames).body == whole.body);
}

INSTANTIATE_TEST_SUITE_P(Disks, DiskErrors, ::testing::Values("damaged-disk", "slow-damaged-disk"),
                         [](const auto& test) {
                           return test.param[0] == 's' ? "ReadInThePool" : "ReadInMemory";
                         });

}  // namespace
}  // namespace isosplat::server::test
