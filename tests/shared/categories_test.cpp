#include "shared/core/categories/categories.h"

#include <gtest/gtest.h>

namespace isosplat {
namespace {

std::string metadata(const std::string& categories) {
  return R"({"name":"a","categories":)" + categories + "}";
}

TEST(Categories, AreReadAsTheyWereWritten) {
  const std::vector<Category> written{
      {-3, "", {1, 2, 255}}, {0, "background", {158, 158, 158}}, {7, "Sehhügel \"x\"", {0, 0, 0}}};
  const auto read = categories_of(metadata(categories_json(written)));
  ASSERT_EQ(read.size(), written.size());
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].value, written[i].value);
    EXPECT_EQ(read[i].name, written[i].name);
    EXPECT_EQ(read[i].colour, written[i].colour);
  }
}

TEST(Categories, LongNamesAreCutAndManyLeftOut) {
  std::vector<Category> many;
  for (int i = 0; i < 600; ++i) many.push_back({i, std::string(300, 'a'), {9, 9, 9}});
  const std::string text = categories_json(many);
  EXPECT_LE(text.size(), kMaxCategoryBytes);
  const auto read = categories_of(metadata(text));
  ASSERT_EQ(read.size(), kMaxCategories);
  EXPECT_EQ(read.front().name, std::string(64, 'a'));
  EXPECT_EQ(read.back().name, "");
  // The longest values leave no room for names, but all of them fit.
  std::vector<Category> longest;
  for (int i = 0; i < 512; ++i) longest.push_back({-kMaxCategory + i, std::string(300, 'a'), {}});
  const std::string of_longest = categories_json(longest);
  EXPECT_LE(of_longest.size(), kMaxCategoryBytes);
  EXPECT_EQ(categories_of(metadata(of_longest)).size(), kMaxCategories);
}

TEST(Categories, NamesHaveNoControlCharacters) {
  const std::vector<Category> written{{1, "b\x01\x1b[31m\na\177d", {}}};
  const std::string text = categories_json(written);
  EXPECT_EQ(text, R"([[1,"#000000","b[31mad"]])");
  const auto read = categories_of(metadata(R"([[1,"#000000","b\u0001\u001b[31mad\u007f"]])"));
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].name, "b[31mad");
}

TEST(Categories, WhatIsMalformedIsLeftOut) {
  EXPECT_TRUE(categories_of("").empty());
  EXPECT_TRUE(categories_of("[1]").empty());
  EXPECT_TRUE(categories_of("{}").empty());
  EXPECT_TRUE(categories_of(metadata("7")).empty());
  const auto some = categories_of(metadata(
      R"([[5,"#0000ff","b"],[1.5,"#000000"],[2,"red"],[3],[4,"#00000g"],[5,"#ffffff"],[1,"#0a0b0c",8],"x",
          [16777217,"#000000"],[4611686018427387904,"#000000"],[-9223372036854775808,"#000000"]])"));
  ASSERT_EQ(some.size(), 2u);
  EXPECT_EQ(some[0].value, 1);
  EXPECT_EQ(some[0].colour, (std::array<uint8_t, 3>{10, 11, 12}));
  EXPECT_EQ(some[1].value, 5);
  EXPECT_EQ(some[1].name, "b");
  // Values too far from the least one.
  EXPECT_EQ(
      categories_of(metadata(R"([[9,"#000000"],[65542,"#000000"],[65543,"#000000"]])")).size(), 2u);
}

}  // namespace
}  // namespace isosplat
