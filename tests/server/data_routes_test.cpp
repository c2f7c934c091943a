// The routes below /v1: volumes, and the bytes of a store under URLs whose meaning never changes.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "server/http/streams.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

using Json = nlohmann::json;

class DataRoutes : public ServerTest {
 protected:
  void SetUp() override { start(); }

  void expect_error(const Answer& answer, int status, const std::string& name) {
    EXPECT_EQ(answer.status, status) << answer.body;
    EXPECT_EQ(answer.header("content-type"), "application/json");
    EXPECT_EQ(answer.header("cache-control"), "no-store");
    EXPECT_EQ(answer.header("cross-origin-resource-policy"), "same-origin");
    const Json body = Json::parse(answer.body, nullptr, false);
    ASSERT_TRUE(body.is_object()) << answer.body;
    EXPECT_EQ(body["status"], name);
    EXPECT_FALSE(body["message"].get<std::string>().empty());
  }

  void expect_immutable(const Answer& answer) {
    EXPECT_EQ(answer.header("cache-control"), "public, max-age=31536000, immutable");
    EXPECT_NE(answer.header("etag").find(alpha.content), std::string::npos);
    EXPECT_EQ(answer.header("content-type").substr(0, 12), "application/");
    EXPECT_EQ(answer.header("cross-origin-resource-policy"), "same-origin");
    EXPECT_EQ(answer.header("x-content-type-options"), "nosniff");
  }
};

TEST_F(DataRoutes, HealthCountsVolumes) {
  const Answer answer = get(port(), "/healthz");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(Json::parse(answer.body), (Json{{"status", "ok"}, {"volumes", 1}, {"broken", 0}}));
  EXPECT_EQ(answer.header("cache-control"), "no-store");
}

TEST_F(DataRoutes, ListHasTheFieldsOfAVolumeCard) {
  const Answer answer = get(port(), "/v1/volumes");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.header("cache-control"), "no-cache");
  const Json volumes = Json::parse(answer.body)["volumes"];
  ASSERT_EQ(volumes.size(), 1u);
  const Json& volume = volumes[0];
  EXPECT_EQ(volume["name"], "alpha");
  EXPECT_EQ(volume["url"], "/v1/volumes/alpha");
  EXPECT_EQ(volume["contentId"], alpha.content);
  EXPECT_EQ(volume["fileBytes"], alpha.file.size());
  EXPECT_EQ(volume["voxels"], Json({200, 140, 70}));
  EXPECT_EQ(volume["title"], "Test 1");
  EXPECT_EQ(volume["type"], "u8");
  EXPECT_EQ(volume["range"], Json({-100.0, 27.5}));
  ASSERT_EQ(volume["histogram"]["counts"].size(), 64u);
  EXPECT_EQ(volume["histogram"]["counts"][1], 4 + 5 + 6 + 7);
}

TEST_F(DataRoutes, VolumeHasTheFieldsOfItsHeader) {
  const Answer answer = get(port(), "/v1/volumes/alpha");
  EXPECT_EQ(answer.status, 200);
  const Json volume = Json::parse(answer.body);
  EXPECT_EQ(volume["contentId"], alpha.content);
  EXPECT_EQ(volume["mapping"]["offset"], -100);
  EXPECT_EQ(volume["mapping"]["scale"], 0.5);
  EXPECT_EQ(volume["quantizedRange"], Json({0, 255}));
  EXPECT_EQ(volume["levels"], alpha.info.levels);
  EXPECT_EQ(volume["levelGrids"][0]["blocks"], Json({4, 3, 2}));
  EXPECT_EQ(volume["metadata"]["histogram"]["counts"].size(), 256u);
  EXPECT_EQ(volume["urls"]["header"], content("header"));
  EXPECT_EQ(
      get(port(), "/v1/volumes/alpha", "If-None-Match: " + answer.header("etag") + "\r\n").status,
      304);
}

TEST_F(DataRoutes, BootstrapHasIdHeaderAndCoarseTail) {
  const Answer answer = get(port(), "/v1/volumes/alpha/bootstrap");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.header("cache-control"), "no-cache");
  EXPECT_EQ(answer.header("content-type"), "application/octet-stream");
  ASSERT_GE(answer.body.size(), kBootstrapHeaderBytes);
  const auto word = [&](size_t at) {
    uint32_t value = 0;
    for (size_t i = 4; i-- > 0;) value = value << 8 | static_cast<uint8_t>(answer.body[at + i]);
    return value;
  };
  const auto part = [&](uint64_t offset, uint64_t bytes) {
    return std::string(reinterpret_cast<const char*>(alpha.file.data()) + offset, bytes);
  };
  const StoreReader reader = *StoreReader::open(alpha.file);
  const CoarseRange range = reader.bootstrap_range();
  const auto& id = alpha.info.content_id;
  EXPECT_EQ(word(0), alpha.info.header_bytes);
  EXPECT_EQ(word(4), range.bytes);
  EXPECT_EQ(word(8) + (uint64_t{word(12)} << 32), range.offset);
  EXPECT_EQ(answer.body.substr(16, 16), std::string(id.begin(), id.end()));
  EXPECT_EQ(answer.body.substr(kBootstrapHeaderBytes),
            part(0, alpha.info.header_bytes) + part(range.offset, range.bytes));
  const std::string etag = "If-None-Match: " + answer.header("etag") + "\r\n";
  EXPECT_EQ(get(port(), "/v1/volumes/alpha/bootstrap", etag).status, 304);
  expect_error(get(port(), "/v1/volumes/beta/bootstrap"), 404, "not_found");
}

TEST_F(DataRoutes, HeaderAndPagesOpenTheStore) {
  const Answer header = get(port(), content("header"));
  EXPECT_EQ(header.status, 200);
  expect_immutable(header);
  EXPECT_TRUE(text_of(alpha.file).starts_with(header.body));
  Result<StoreReader> reader = StoreReader::open(std::as_bytes(std::span(header.body)));
  ASSERT_TRUE(reader) << reader.error().message;
  for (uint32_t page = 0; page < reader->pages().size(); ++page) {
    const Answer answer = get(port(), content("pages/" + std::to_string(page)));
    EXPECT_EQ(answer.status, 200);
    expect_immutable(answer);
    const auto added = reader->add_page(page, std::as_bytes(std::span(answer.body)));
    EXPECT_TRUE(added) << added.error().message;
  }
  const std::string past = std::to_string(reader->pages().size());
  expect_error(get(port(), content("pages/" + past)), 404, "not_found");
  expect_error(get(port(), content("pages/x")), 400, "invalid_argument");
  expect_error(get(port(), content("pages/00")), 400, "invalid_argument");
}

TEST_F(DataRoutes, ChunksEqualThoseOfTheStore) {
  Client client(port());
  for (const KnownChunk& chunk : alpha.chunks) {
    const Answer answer = client.request("GET", content("chunks/" + place_of(chunk)));
    ASSERT_EQ(answer.status, 200) << answer.body;
    ASSERT_EQ(answer.body, text_of(chunk.bytes));
    expect_immutable(answer);
  }
}

TEST_F(DataRoutes, MissingChunksAreNotFound) {
  expect_error(get(port(), content("chunks/0/0.0.0/100")), 404, "not_found");
  expect_error(get(port(), content("chunks/0/4.0.0/0")), 404, "not_found");
  expect_error(get(port(), content("chunks/0/1048577.0.0/0")), 400, "invalid_argument");
  expect_error(get(port(), content("chunks/31/0.0.0/0")), 404, "not_found");
  expect_error(get(port(), content("chunks/0/0.0/0")), 400, "invalid_argument");
  expect_error(get(port(), content("chunks/0/0.0.-1/0")), 400, "invalid_argument");
  expect_error(get(port(), content("chunks/0/0.0.00/0")), 400, "invalid_argument");
  expect_error(get(port(), content("chunks/0/0.0.0/0/0")), 404, "not_found");
  expect_error(get(port(), content("nothing")), 404, "not_found");
  expect_error(get(port(), "/v1/volumes/beta"), 404, "not_found");
  expect_error(get(port(), "/v1/other"), 404, "not_found");
}

TEST_F(DataRoutes, AnotherContentIdIsNotFound) {
  const std::string other(32, '0');
  const Answer answer = get(port(), "/v1/volumes/alpha/" + other + "/header");
  expect_error(answer, 404, "not_found");
  EXPECT_NE(answer.body.find(alpha.content), std::string::npos) << "the hint";
  std::string upper = alpha.content;
  for (char& c : upper) c = static_cast<char>(std::toupper(c));
  expect_error(get(port(), "/v1/volumes/alpha/" + upper + "/header"), 404, "not_found");
}

TEST_F(DataRoutes, ConditionalRequests) {
  const std::string url = content("chunks/" + place_of(alpha.chunks.front()));
  const std::string etag = get(port(), url).header("etag");
  const auto status = [&](const std::string& headers) { return get(port(), url, headers).status; };
  EXPECT_EQ(status("If-None-Match: " + etag + "\r\n"), 304);
  EXPECT_EQ(status("If-None-Match: \"other\", W/" + etag + "\r\n"), 304);
  EXPECT_EQ(status("If-None-Match: *\r\n"), 304);
  EXPECT_EQ(status("If-None-Match: \"other\"\r\n"), 200);
  EXPECT_EQ(status("If-None-Match: garbage\r\n"), 200);
  EXPECT_EQ(status("If-Match: " + etag + "\r\n"), 200);
  EXPECT_EQ(status("If-Match: *\r\n"), 200);
  EXPECT_EQ(status("If-Match: \"other\"\r\n"), 412);
  EXPECT_EQ(status("If-Match: W/" + etag + "\r\n"), 412) << "If-Match compares strongly";
  EXPECT_EQ(status("If-Modified-Since: Sun, 06 Nov 2094 08:49:37 GMT\r\n"), 200);
  const Answer unchanged = get(port(), url, "If-None-Match: " + etag + "\r\n");
  EXPECT_EQ(unchanged.header("etag"), etag);
  EXPECT_EQ(unchanged.header("content-length"), "");
  EXPECT_EQ(get(port(), content("chunks/0/9.9.9/0"), "If-None-Match: *\r\n").status, 404);
  // Conditions apply to every response with an ETag.
  for (const char* volume : {"/v1/volumes", "/v1/volumes/alpha", "/v1/volumes/alpha/bootstrap"}) {
    const std::string own = get(port(), volume).header("etag");
    EXPECT_EQ(get(port(), volume, "If-Match: " + own + "\r\n").status, 200) << volume;
    EXPECT_EQ(get(port(), volume, "If-Match: \"other\"\r\n").status, 412) << volume;
  }
}

TEST_F(DataRoutes, HeadHasTheFieldsOfGet) {
  Client client(port());
  for (const std::string& url :
       {std::string("/healthz"), std::string("/v1/volumes"), content("header"), content("file"),
        content("chunks/" + place_of(alpha.chunks.front())), content("chunks?isovalue=0&level=0"),
        std::string("/v1/volumes/none")}) {
    Answer with_body = client.request("GET", url);
    const Answer without = client.request("HEAD", url);
    EXPECT_EQ(with_body.status, without.status) << url;
    for (const char* name : {"content-length", "content-type", "etag", "cache-control"}) {
      EXPECT_EQ(with_body.header(name), without.header(name)) << url << " " << name;
    }
  }
}

TEST_F(DataRoutes, OptionsAnswersPreflights) {
  options.cross_origin = CrossOrigin{.any = true, .origins = {}};
  start();
  const Answer answer =
      Client(port()).request("OPTIONS", content("file"),
                             "Origin: https://example.org\r\nAccess-Control-Request-Method: GET\r\n"
                             "Access-Control-Request-Headers: range\r\n");
  EXPECT_EQ(answer.status, 204);
  EXPECT_EQ(answer.header("allow"), "GET, HEAD, OPTIONS");
  EXPECT_EQ(answer.header("access-control-allow-origin"), "*");
  EXPECT_NE(answer.header("access-control-allow-headers").find("Range"), std::string::npos);
  EXPECT_EQ(answer.header("content-length"), "");
  EXPECT_EQ(Client(port()).request("OPTIONS", "*").status, 204);
}

TEST_F(DataRoutes, OtherMethodsAreRefused) {
  for (const char* method : {"POST", "PUT", "DELETE", "PATCH", "TRACE", "PROPFIND", "BREW"}) {
    const Answer answer = Client(port()).request(method, "/v1/volumes");
    EXPECT_EQ(answer.status, 405) << method;
    EXPECT_EQ(answer.header("allow"), "GET, HEAD, OPTIONS");
  }
  EXPECT_EQ(Client(port()).request("CONNECT", "example.org:443").status, 405);
}

TEST_F(DataRoutes, ManyClientsAtOnce) {
  std::vector<std::thread> threads;
  std::atomic<int> wrong{0};
  for (int thread = 0; thread < 8; ++thread) {
    threads.emplace_back([&, thread] {
      Client client(port());
      for (size_t i = 0; i < alpha.chunks.size(); ++i) {
        const KnownChunk& chunk =
            alpha.chunks[(i * 7 + static_cast<size_t>(thread)) % alpha.chunks.size()];
        const Answer answer = client.request("GET", content("chunks/" + place_of(chunk)));
        if (answer.status != 200 || answer.body != text_of(chunk.bytes)) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(DataRoutes, FileByRange) {
  const std::string file = text_of(alpha.file);
  const std::string size = std::to_string(file.size());
  const std::string url = content("file");
  Client client(port());
  const Answer whole = client.request("GET", url);
  EXPECT_EQ(whole.status, 200);
  EXPECT_EQ(whole.body, file);
  EXPECT_EQ(whole.header("accept-ranges"), "bytes");
  expect_immutable(whole);

  struct Part {
    std::string range;
    size_t first;
    size_t last;
  };
  const size_t end = file.size() - 1;
  for (const Part& part : {
           Part{"bytes=0-0", 0, 0},
           Part{"bytes=0-99", 0, 99},
           Part{"bytes=100-200000", 100, std::min<size_t>(200000, end)},
           Part{"bytes=100-", 100, end},
           Part{"bytes=-1", end, end},
           Part{"bytes=-500", end - 499, end},
           Part{"bytes=-99999999999", 0, end},
           Part{"bytes=-99999999999999999999999999", 0, end},
           Part{"bytes=5-99999999999999999999999999", 5, end},
           Part{"Bytes = 7-8 ", 7, 8},
           Part{"bytes=" + std::to_string(end) + "-", end, end},
       }) {
    const Answer answer = client.request("GET", url, "Range: " + part.range + "\r\n");
    EXPECT_EQ(answer.status, 206) << part.range;
    EXPECT_EQ(answer.header("content-range"),
              "bytes " + std::to_string(part.first) + "-" + std::to_string(part.last) + "/" + size);
    EXPECT_EQ(answer.body, file.substr(part.first, part.last - part.first + 1)) << part.range;
  }
  for (const std::string& range :
       {"bytes=" + size + "-", std::string("bytes=-0"), std::string("bytes=99999999999999999999-"),
        "bytes=" + size + "-" + size}) {
    const Answer answer = client.request("GET", url, "Range: " + range + "\r\n");
    expect_error(answer, 416, "range_not_satisfiable");
    EXPECT_EQ(answer.header("content-range"), "bytes */" + size);
  }
  for (const char* range : {"bytes=5-4", "bytes=", "bytes=-", "bytes=a-b", "bytes=1", "lines=1-2",
                            "bytes=0-1,3-4", "bytes=0-1,", "bytes=+1-2", "bytes 0-1", "0-1",
                            "bytes=1-2-3", "bytes=--1", "bytes=0x1-2"}) {
    const Answer answer = client.request("GET", url, std::string("Range: ") + range + "\r\n");
    EXPECT_EQ(answer.status, 200) << range;
    EXPECT_EQ(answer.body.size(), file.size()) << range;
  }
}

TEST_F(DataRoutes, RangeWithConditions) {
  const std::string url = content("file");
  const std::string etag = get(port(), url).header("etag");
  const auto ask = [&](const std::string& headers) {
    return get(port(), url, "Range: bytes=1-2\r\n" + headers);
  };
  EXPECT_EQ(ask("If-Range: " + etag + "\r\n").status, 206);
  EXPECT_EQ(ask("If-Range: W/" + etag + "\r\n").status, 200) << "If-Range compares strongly";
  EXPECT_EQ(ask("If-Range: \"other\"\r\n").status, 200);
  EXPECT_EQ(ask("If-Range: Sun, 06 Nov 1994 08:49:37 GMT\r\n").status, 200);
  EXPECT_EQ(ask("If-None-Match: " + etag + "\r\n").status, 304);
  EXPECT_EQ(ask("If-Match: \"other\"\r\n").status, 412);
  const Answer header = Client(port()).request("HEAD", url, "Range: bytes=1-2\r\n");
  EXPECT_EQ(header.status, 200) << "Range is for GET";
  EXPECT_EQ(header.header("content-length"), std::to_string(alpha.file.size()));
}

}  // namespace
}  // namespace isosplat::server::test
