#include "server/http/target.h"

#include <gtest/gtest.h>

namespace isosplat::server {
namespace {

std::string path_of(std::string_view raw) {
  const Result<Target> target = parse_target(raw);
  return target ? target->path() : "error";
}

TEST(Target, Paths) {
  EXPECT_EQ(path_of("/"), "/");
  EXPECT_EQ(path_of("/?a=1"), "/");
  EXPECT_EQ(path_of("/v1/volumes"), "/v1/volumes");
  EXPECT_EQ(path_of("/v1/volumes/"), "/v1/volumes/");
  EXPECT_EQ(path_of("//x"), "//x");
  EXPECT_EQ(path_of("/a%20b"), "/a b");
  EXPECT_EQ(path_of("/%C3%A9"), "/é");
  EXPECT_EQ(path_of("http://example.org/x"), "/x");
  EXPECT_EQ(path_of("https://example.org"), "/");
  EXPECT_EQ(path_of("http://example.org?x=1"), "/");
  EXPECT_EQ(path_of("/..."), "/...");
}

TEST(Target, EscapesAreDecodedOnce) {
  EXPECT_EQ(path_of("/%2541"), "/%41");
  EXPECT_EQ(path_of("/%252e%252e/x"), "/%2e%2e/x");
}

TEST(Target, Refused) {
  for (const char* raw : {"",
                          "x",
                          "*",
                          "example.org:443",
                          "ftp://x/",
                          "/..",
                          "/../x",
                          "/x/..",
                          "/.",
                          "/./x",
                          "/%2e%2e/x",
                          "/%2E%2e",
                          "/.%2e",
                          "/%2e",
                          "/a%2fb",
                          "/a%5cb",
                          "/a\\b",
                          "/%",
                          "/%4",
                          "/%4g",
                          "/%g4",
                          "/%%41",
                          "/%00",
                          "/%0d%0a",
                          "/%7f",
                          "/a b",
                          "/\x01",
                          "/\x80",
                          "/#x",
                          "/\"",
                          "/<",
                          "/v1?a=%",
                          "/v1/x?a=%0a",
                          "/v1?%zz=1"}) {
    EXPECT_EQ(path_of(raw), "error") << raw;
    const Result<Target> target = parse_target(raw);
    ASSERT_FALSE(target);
    EXPECT_EQ(target.error().status, Status::invalid_argument);
  }
}

TEST(Target, Queries) {
  const Result<Target> page = parse_target("/?src=%&volume=a&x=%0a");
  ASSERT_TRUE(page) << "the script of the page reports invalid parameters";
  EXPECT_EQ(page->query, (std::vector<std::pair<std::string, std::string>>{{"volume", "a"}}));

  const Result<Target> target = parse_target("/x?a=1&b=%2F0/1&&c&=d&e=f=g&h=1e+5&a=2");
  ASSERT_TRUE(target);
  using Pairs = std::vector<std::pair<std::string, std::string>>;
  EXPECT_EQ(target->query, (Pairs{{"a", "1"},
                                  {"b", "/0/1"},
                                  {"c", ""},
                                  {"", "d"},
                                  {"e", "f=g"},
                                  {"h", "1e+5"},
                                  {"a", "2"}}));
}

TEST(Target, IndicesHaveOneSpelling) {
  EXPECT_EQ(parse_index("0"), 0u);
  EXPECT_EQ(parse_index("4294967295"), 4294967295u);
  EXPECT_EQ(parse_index("10", 10), 10u);
  for (const char* text :
       {"", "00", "01", "-1", "+1", " 1", "1 ", "0x1", "1.0", "4294967296", "99999999999", "१"}) {
    EXPECT_EQ(parse_index(text), std::nullopt) << text;
  }
  EXPECT_EQ(parse_index("11", 10), std::nullopt);
}

TEST(Target, Blocks) {
  EXPECT_EQ(parse_block("1.2.3"), (Index3{1, 2, 3}));
  for (const char* text :
       {"", "1", "1.2", "1.2.", ".1.2", "1..2", "1.2.3.4", "1.2.1048577", "1,2,3", "-1.0.0"}) {
    EXPECT_EQ(parse_block(text), std::nullopt) << text;
  }
  EXPECT_EQ(parse_blocks("1.2.3,0.0.0")->size(), 2u);
  for (const char* text : {"", ",", "1.2.3,", ",1.2.3", "1.2.3,,1.2.3", "1.2.3;1.2.3"}) {
    EXPECT_FALSE(parse_blocks(text)) << text;
  }
}

TEST(Target, Values) {
  EXPECT_EQ(parse_value("60.5"), 60.5);
  EXPECT_EQ(parse_value("-1000"), -1000);
  EXPECT_EQ(parse_value("1e+3"), 1000);
  for (const char* text : {"", "nan", "inf", "-inf", "1e999", "0x10", "1,5", " 1", "1 ", "one"}) {
    EXPECT_EQ(parse_value(text), std::nullopt) << text;
  }
  const auto range = parse_value_range("-2.5..3");
  ASSERT_TRUE(range);
  EXPECT_EQ(range->low, -2.5);
  EXPECT_EQ(range->high, 3);
  EXPECT_EQ(parse_value_range("7")->high, 7);
  for (const char* text : {"", "..", "1..", "..1", "3..2", "1...", "1..2..3", "nan..1", "1-2"}) {
    EXPECT_FALSE(parse_value_range(text)) << text;
  }
}

TEST(Target, Chunks) {
  const auto chunks = parse_chunks("0/1.2.3/4,2/0.0.0/0");
  ASSERT_TRUE(chunks);
  ASSERT_EQ(chunks->size(), 2u);
  EXPECT_EQ((*chunks)[0].block, (BlockKey{0, {1, 2, 3}}));
  EXPECT_EQ((*chunks)[0].band, 4u);
  for (const char* text : {"", "0", "0/1.2.3", "0/1.2.3/", "/1.2.3/4", "0/1.2.3/4/5", "32/1.2.3/4",
                           "0/1.2.3/65536", "0/1.2.3/4,"}) {
    EXPECT_FALSE(parse_chunks(text)) << text;
  }
  // Messages shorten the text that a client has sent.
  EXPECT_LT(parse_chunks(std::string(5000, 'x')).error().message.size(), 200u);
}

}  // namespace
}  // namespace isosplat::server
