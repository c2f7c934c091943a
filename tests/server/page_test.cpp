// The page's files: types, encodings, caching, and that nothing outside the folder is reachable.

#include <gtest/gtest.h>

#include <zlib.h>
#include <algorithm>

#include <filesystem>

#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

namespace fs = std::filesystem;

std::string gunzipped(const std::string& bytes) {
  z_stream stream{};
  inflateInit2(&stream, MAX_WBITS + 16);
  std::string out(1 << 20, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  inflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  inflateEnd(&stream);
  return out;
}

class Page : public ServerTest {
 protected:
  Page() {
    const fs::path root = page.path() / "root";
    fs::create_directories(root / "assets");
    write_file(root / "index.html", "<!doctype html><title>Isosplat</title>");
    write_file(root / "assets/index-Ab3_x-9Z.js", script);
    write_file(root / "assets/index-Ab3_x-9Z.js.br", std::string_view("brotli"));
    write_file(root / "assets/plain.js", std::string_view("1"));
    write_file(root / "assets/core-12345678.wasm", std::string_view("\0asm", 4));
    write_file(root / "assets/font-12345678.woff2", std::string_view("font"));
    write_file(root / "empty.txt", std::string_view(""));
    write_file(root / "a b.txt", std::string_view("space"));
    write_file(page.path() / "secret.txt", std::string_view("secret"));
    fs::create_symlink(page.path() / "secret.txt", root / "link.txt");
    fs::create_directory_symlink(page.path(), root / "folder");
    fs::create_symlink(root / "index.html", root / "inside.html");
    options.web_root = root;
  }

  TemporaryFolder page;
  const std::string script = std::string(5000, 'x') + "();";
};

TEST_F(Page, IndexIsRevalidated) {
  start();
  for (const char* url : {"/", "/index.html", "/?volume=alpha&isovalue=60.5"}) {
    const Answer answer = get(port(), url);
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.header("content-type"), "text/html; charset=utf-8");
    EXPECT_EQ(answer.header("cache-control"), "no-cache");
    EXPECT_EQ(answer.header("vary"), "Accept-Encoding");
    EXPECT_EQ(answer.header("x-content-type-options"), "nosniff");
    EXPECT_EQ(answer.header("access-control-allow-origin"), "");
    const std::string policy = answer.header("content-security-policy");
    for (const char* part :
         {"default-src 'none';", "script-src 'self' 'wasm-unsafe-eval';",
          "worker-src 'self' blob:;", "style-src 'self' 'unsafe-inline';", "base-uri 'none'",
          "connect-src 'self' http: https: data: blob:;", "form-action 'none'"}) {
      EXPECT_NE(policy.find(part), std::string::npos) << part;
    }
    EXPECT_EQ(policy.find("frame-ancestors"), std::string::npos) << "other sites may embed it";
    const Answer again = get(port(), url, "If-None-Match: " + answer.header("etag") + "\r\n");
    EXPECT_EQ(again.status, 304);
    EXPECT_EQ(again.header("etag"), answer.header("etag"));
    EXPECT_EQ(again.header("vary"), "Accept-Encoding");
  }
}

TEST_F(Page, EveryFileHasThePolicy) {
  start();
  const std::string policy = get(port(), "/").header("content-security-policy");
  // A worker, or a file that is opened as a page, has the policy of its own response.
  for (const char* url : {"/assets/index-Ab3_x-9Z.js", "/assets/plain.js", "/empty.txt", "/none"}) {
    EXPECT_EQ(get(port(), url).header("content-security-policy"), policy) << url;
  }
}

TEST_F(Page, ScriptsRunInPagesOfTheOriginsThatMayReadData) {
  options.cross_origin = *parse_cross_origin("https://a.example");
  start();
  const char* const url = "/assets/plain.js";
  const Answer listed = get(port(), url, "Origin: https://a.example\r\n");
  EXPECT_EQ(listed.header("access-control-allow-origin"), "https://a.example");
  EXPECT_EQ(listed.header("cross-origin-resource-policy"), "cross-origin");
  // A cache that holds a response without the field must not give it to the other page.
  const auto varies = [](const Answer& answer, const char* by) {
    const std::pair<const std::string, std::string> field("vary", by);
    return std::ranges::count(answer.headers, field) == 1;
  };
  EXPECT_TRUE(varies(listed, "Origin") && varies(listed, "Accept-Encoding"));
  const Answer other = get(port(), url, "Origin: https://c.example\r\n");
  EXPECT_EQ(other.header("access-control-allow-origin"), "");
  EXPECT_TRUE(varies(other, "Origin") && varies(other, "Accept-Encoding"));
}

TEST_F(Page, ScriptsRunInEveryPageIfEveryPageMayReadData) {
  options.cross_origin = *parse_cross_origin("*");
  start();
  const Answer answer = get(port(), "/assets/plain.js", "Origin: https://c.example\r\n");
  EXPECT_EQ(answer.header("access-control-allow-origin"), "*");
  EXPECT_EQ(answer.header("vary"), "Accept-Encoding");
}

TEST_F(Page, NamesTheVolumesFirstBytes) {
  start();
  EXPECT_EQ(get(port(), "/?volume=alpha").header("link"),
            "<v1/volumes/alpha/bootstrap>; rel=preload; as=fetch; crossorigin=anonymous");
  for (const char* url : {"/", "/?volume=beta", "/?volume=%0d%0aX:y", "/empty.txt?volume=alpha"}) {
    EXPECT_EQ(get(port(), url).header("link"), "") << url;
  }
}

TEST_F(Page, HashedNamesAreImmutable) {
  start();
  const std::string immutable = "public, max-age=31536000, immutable";
  EXPECT_EQ(get(port(), "/assets/index-Ab3_x-9Z.js").header("cache-control"), immutable);
  EXPECT_EQ(get(port(), "/assets/core-12345678.wasm").header("cache-control"), immutable);
  EXPECT_EQ(get(port(), "/assets/plain.js").header("cache-control"), "no-cache");
}

TEST_F(Page, Types) {
  start();
  EXPECT_EQ(get(port(), "/assets/index-Ab3_x-9Z.js").header("content-type"),
            "text/javascript; charset=utf-8");
  EXPECT_EQ(get(port(), "/assets/core-12345678.wasm").header("content-type"), "application/wasm");
  EXPECT_EQ(get(port(), "/assets/font-12345678.woff2").header("content-type"), "font/woff2");
  EXPECT_EQ(get(port(), "/empty.txt").header("content-length"), "0");
  EXPECT_EQ(get(port(), "/a%20b.txt").body, "space");
}

TEST_F(Page, EncodingFollowsAcceptEncoding) {
  start();
  const std::string url = "/assets/index-Ab3_x-9Z.js";
  const Answer plain = get(port(), url);
  EXPECT_EQ(plain.body, script);
  EXPECT_EQ(plain.header("content-encoding"), "");
  const Answer gzip = get(port(), url, "Accept-Encoding: gzip, deflate\r\n");
  EXPECT_EQ(gzip.header("content-encoding"), "gzip");
  EXPECT_EQ(gunzipped(gzip.body), script);
  const Answer brotli = get(port(), url, "Accept-Encoding: gzip, deflate, br, zstd\r\n");
  EXPECT_EQ(brotli.header("content-encoding"), "br");
  EXPECT_EQ(brotli.body, "brotli");
  EXPECT_EQ(get(port(), url, "Accept-Encoding: br;q=0, gzip;q=0\r\n").body, script);
  EXPECT_NE(plain.header("etag"), gzip.header("etag"));
  EXPECT_NE(gzip.header("etag"), brotli.header("etag"));
  EXPECT_EQ(
      get(port(), url, "Accept-Encoding: gzip\r\nIf-None-Match: " + plain.header("etag") + "\r\n")
          .status,
      200)
      << "another encoding is another representation";
}

TEST_F(Page, FilesOutsideTheFolderAreNotServed) {
  start();
  for (const char* url :
       {"/../secret.txt", "/%2e%2e/secret.txt", "/%2e%2e%2fsecret.txt", "/..%2fsecret.txt",
        "/%252e%252e/secret.txt", "/assets/../../secret.txt", "/..\\secret.txt", "/..%5csecret.txt",
        "//etc/passwd", "/etc/passwd", "/link.txt", "/folder/secret.txt", "/assets", "/assets/",
        "/index.html/", "/index.html%00.js", "/assets/index-Ab3_x-9Z.js.br"}) {
    const Answer answer = get(port(), url);
    EXPECT_TRUE(answer.status == 400 || answer.status == 404) << url << " " << answer.status;
    EXPECT_EQ(answer.body.find("secret"), std::string::npos) << url;
  }
  EXPECT_EQ(get(port(), "/inside.html").status, 200);
  EXPECT_TRUE(will_log("link.txt: a link out of the folder"));
}

TEST_F(Page, IsReadAgainWhenItChanges) {
  start();
  write_file(options.web_root / "index.html", std::string_view("new"));
  EXPECT_TRUE(eventually([&] { return get(port(), "/").body == "new"; }));
  write_file(options.web_root / "added.txt", std::string_view("added"));
  EXPECT_TRUE(eventually([&] { return get(port(), "/added.txt").status == 200; }));
}

TEST_F(Page, OldHashedFilesAreStillServedAfterARebuild) {
  start();
  const fs::path old_script = options.web_root / "assets/index-Ab3_x-9Z.js";
  fs::remove(old_script);
  fs::remove(options.web_root / "assets/plain.js");
  write_file(options.web_root / "assets/index-NEW_NEW1.js", std::string_view("new"));
  write_file(options.web_root / "index.html",
             std::string_view("<script src=\"./assets/index-NEW_NEW1.js\"></script>"));
  EXPECT_TRUE(
      eventually([&] { return get(port(), "/").body.find("NEW_NEW1") != std::string::npos; }));
  EXPECT_EQ(get(port(), "/assets/index-NEW_NEW1.js").body, "new");
  EXPECT_EQ(get(port(), "/assets/index-Ab3_x-9Z.js").body, script);
  EXPECT_EQ(get(port(), "/assets/plain.js").status, 404)
      << "its name contains no hash of its content";
}

TEST_F(Page, AHalfWrittenPageIsNotServed) {
  start();
  write_file(options.web_root / "index.html",
             std::string_view("<script src=\"./assets/index-NEW_NEW1.js\"></script>"));
  EXPECT_TRUE(will_log("index-NEW_NEW1.js, which does not exist"));
  EXPECT_EQ(get(port(), "/").body, "<!doctype html><title>Isosplat</title>");
  write_file(options.web_root / "assets/index-NEW_NEW1.js", std::string_view("new"));
  EXPECT_TRUE(
      eventually([&] { return get(port(), "/").body.find("NEW_NEW1") != std::string::npos; }));
}

TEST_F(Page, WithoutAPageTheRootIsAnExplanation) {
  options.web_root.clear();
  start();
  const Answer answer = get(port(), "/");
  EXPECT_EQ(answer.status, 200);
  EXPECT_NE(answer.body.find("/v1/volumes"), std::string::npos);
  EXPECT_EQ(get(port(), "/index.html").status, 404);
}

TEST_F(Page, AMissingFolderIsReportedAtTheStart) {
  options.web_root = page.path() / "none";
  const auto started = Server::start(options);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().status, Status::io_error);
  EXPECT_NE(started.error().message.find("none"), std::string::npos);
}

TEST_F(Page, ATooLargeFolderIsReportedAtTheStart) {
  options.limits.page_asset_bytes = 1000;
  const auto started = Server::start(options);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().status, Status::invalid_argument);
}

}  // namespace
}  // namespace isosplat::server::test
