// The values that slices show as black and white. tests/web/grey_range.spec.ts has the same table.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "native/headless/grey_range.h"

namespace isosplat {
namespace {

TEST(RenderGreyRange, FollowsTheTable) {
  std::ifstream file(ISOSPLAT_SOURCE_DIR "/tests/support/grey_ranges.json");
  const auto table = nlohmann::json::parse(file);
  ASSERT_GE(table.size(), 8u);
  for (const auto& row : table) {
    const GreyRange all{row["range"][0], row["range"][1]};
    const GreyRange found = grey_range(row["metadata"].dump(), all);
    EXPECT_DOUBLE_EQ(found.low, row["greys"][0]) << row["what"];
    EXPECT_DOUBLE_EQ(found.high, row["greys"][1]) << row["what"];
  }
}

TEST(RenderGreyRange, IsThatOfAllValuesForDamagedMetadata) {
  for (const char* text : {"", "{", "[]", "3", R"({"histogram": 3})"}) {
    const GreyRange found = grey_range(text, {-2, 5});
    EXPECT_EQ(found.low, -2) << text;
    EXPECT_EQ(found.high, 5) << text;
  }
}

}  // namespace
}  // namespace isosplat
