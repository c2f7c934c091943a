#include <gtest/gtest.h>

#include <fstream>

#include "tests/golden/digest.h"

namespace isosplat {
namespace {

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Golden, StoresOfEveryVersionDecodeToWhatTheyDidThen) {
  for (const std::string version : {"v1.0"}) {
    for (const std::string name : {"tiny", "u8", "i16", "f32_missing", "u32"}) {
      SCOPED_TRACE(version + " " + name);
      const std::string path = std::string(ISOSPLAT_GOLDEN) + "/" + version + "/" + name;
      const std::string store = content(path + ".isosplat");
      ASSERT_FALSE(store.empty());
      EXPECT_EQ(digest_of(std::as_bytes(std::span(store.data(), store.size()))),
                content(path + ".txt"));
    }
  }
}

}  // namespace
}  // namespace isosplat
