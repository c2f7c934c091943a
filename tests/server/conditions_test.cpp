#include "server/http/conditions.h"

#include <gtest/gtest.h>

#include "server/http/message.h"

namespace isosplat::server {
namespace {

TEST(Conditions, EtagLists) {
  EXPECT_TRUE(names_etag("\"a\"", "\"a\"", true));
  EXPECT_TRUE(names_etag(" \"b\" ,\t\"a\"", "\"a\"", true));
  EXPECT_TRUE(names_etag("W/\"a\"", "\"a\"", true));
  EXPECT_FALSE(names_etag("W/\"a\"", "\"a\"", false));
  EXPECT_TRUE(names_etag("*", "\"a\"", false));
  EXPECT_TRUE(names_etag("\"x,y\", \"a\"", "\"a\"", false)) << "a comma inside a tag";
  for (const char* field :
       {"", "a", "\"a", "\"b\" \"a\"", "w/\"a\"", "\"A\"", ",,", "\"\"", "**"}) {
    EXPECT_FALSE(names_etag(field, "\"a\"", true)) << field;
  }
}

TEST(Conditions, RangesOfAnEmptyResource) {
  EXPECT_EQ(parse_range("bytes=0-", 0).kind, RangeKind::unsatisfiable);
  EXPECT_EQ(parse_range("bytes=-5", 0).kind, RangeKind::unsatisfiable);
  EXPECT_EQ(parse_range("", 0).kind, RangeKind::whole);
}

TEST(Conditions, AcceptEncoding) {
  EXPECT_TRUE(accepts_encoding("gzip, deflate, br", Encoding::brotli));
  EXPECT_TRUE(accepts_encoding("gzip, deflate, br", Encoding::gzip));
  EXPECT_TRUE(accepts_encoding("GZIP;q=0.5", Encoding::gzip));
  EXPECT_TRUE(accepts_encoding("*", Encoding::gzip));
  EXPECT_TRUE(accepts_encoding("x-gzip", Encoding::gzip));
  EXPECT_FALSE(accepts_encoding("", Encoding::gzip));
  EXPECT_FALSE(accepts_encoding("gzip;q=0", Encoding::gzip));
  EXPECT_FALSE(accepts_encoding("gzip; q=0.000", Encoding::gzip));
  EXPECT_FALSE(accepts_encoding("*, gzip;q=0", Encoding::gzip));
  EXPECT_TRUE(accepts_encoding("*, br;q=0", Encoding::gzip));
  EXPECT_FALSE(accepts_encoding("identity", Encoding::gzip));
  EXPECT_FALSE(accepts_encoding("gzipped", Encoding::gzip));
  EXPECT_FALSE(accepts_encoding("*;q=0", Encoding::brotli));
}

TEST(Json, StringsAreEscaped) {
  EXPECT_EQ(json_string("a\"b\\c\nd\x01\x7f"), "\"a\\\"b\\\\c\\nd\\u0001\\u007f\"");
  EXPECT_EQ(json_string("é日𝄞"), "\"é日𝄞\"");
  EXPECT_EQ(json_string("\xff"), "\"\xef\xbf\xbd\"");
  EXPECT_EQ(json_string("\xc3"), "\"\xef\xbf\xbd\"") << "cut off";
  EXPECT_EQ(json_string("\xc0\x80"), "\"\xef\xbf\xbd\xef\xbf\xbd\"") << "overlong";
  EXPECT_EQ(json_string("\xed\xa0\x80"), "\"\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\"") << "surrogate";
}

}  // namespace
}  // namespace isosplat::server
