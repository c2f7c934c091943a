#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "native/build/builder.h"
#include "native/import/open_volume.h"
#include "tests/native/brute_force.h"

namespace isosplat {
namespace {

struct Expectation {
  std::string volume;
  double most_of_raw;   ///< the whole store against the voxels
  double isovalue;      ///< one isovalue of level 0
  uint64_t most_bytes;  ///< takes at most these bytes
};

class BuildSizes : public testing::TestWithParam<Expectation> {};

TEST_P(BuildSizes, StayWithinTheirMarks) {
  const auto& [name, most_of_raw, isovalue, most_bytes] = GetParam();
  const char* chosen = std::getenv("ISOSPLAT_VOLUMES");
  const std::filesystem::path folder = chosen ? chosen : ISOSPLAT_SOURCE "/../shared/volumes";
  if (!std::filesystem::exists(folder / name)) GTEST_SKIP() << name << " is not in " << folder;
  const auto volume = open_volume(folder / name, {});
  ASSERT_TRUE(volume) << volume.error().message;
  MemorySink sink;
  const auto report = build_store(*volume->source, sink, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_LE(static_cast<double>(sink.bytes.size()),
            most_of_raw * static_cast<double>(report->raw_bytes));
  const StoreReader reader = open_whole(sink.bytes);
  const float isocode = reader.info().mapping.isocode(isovalue);
  uint64_t bytes = 0;
  const auto chunks = reader.chunks_for(0, isocode, isocode);
  for (const ChunkRef& chunk : *chunks) bytes += chunk.bytes;
  EXPECT_LE(bytes, most_bytes);
}

INSTANTIATE_TEST_SUITE_P(Volumes, BuildSizes,
                         testing::Values(Expectation{"engine.nhdr", 0.70, 60.5, 430'000},
                                         Expectation{"bonsai.nhdr", 0.85, 100.5, 430'000},
                                         Expectation{"aneurysm.nhdr", 0.85, 100.5, 190'000},
                                         Expectation{"bunny_ct_i16.nrrd", 0.52, 1000.5, 4'800'000},
                                         Expectation{"lobster.nhdr", 0.85, 60.5, 262'000},
                                         Expectation{"statueLeg.nhdr", 0.85, 60.5, 219'000}),
                         [](const auto& test) {
                           return test.param.volume.substr(0, test.param.volume.find('.'));
                         });

}  // namespace
}  // namespace isosplat
