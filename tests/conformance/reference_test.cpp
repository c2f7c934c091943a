#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/conformance/compare.h"
#include "tests/native/test_files.h"

// Compares generated files with other programs' readers. This finds errors in the understanding of
// a specification that the generator and the importer share. A reader that is not installed is
// skipped.
namespace isosplat::conformance {
namespace {

using nlohmann::json;

constexpr int kFiles = 60;

struct Reader {
  Format format;
  int min_read;  ///< minimum number of files of kFiles that the reader must be able to read
};

Vec3d vector_of(const json& numbers) {
  return {numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>()};
}

Truth truth_of(const json& answer) {
  Truth truth;
  for (size_t i = 0; i < 3; ++i) {
    truth.sizes[i] = answer["sizes"][i].get<int>();
    truth.steps[i] = vector_of(answer["steps"][i]);
  }
  truth.origin = vector_of(answer["origin"]);
  truth.values = answer["values"].get<std::vector<double>>();
  return truth;
}

/// The results of reference_readers.py, one per request. It runs in Debian's Python, which has
/// Debian's packages, even if another Python is first on PATH.
std::vector<json> run_reader(const char* format, const std::vector<json>& requests) {
  const test::TempFolder folder;
  std::string lines;
  for (const json& request : requests) lines += request.dump() + "\n";
  test::write_file(folder / "requests", lines);
  const std::string command = "/usr/bin/python3 '" ISOSPLAT_SOURCE_DIR
                              "/tests/conformance/reference_readers.py' " +
                              std::string(format) + " < '" + (folder / "requests").string() +
                              "' > '" + (folder / "results").string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  std::vector<json> results;
  std::istringstream text(test::read_file(folder / "results"));
  for (std::string line; std::getline(text, line);) results.push_back(json::parse(line));
  return results;
}

class Reference : public testing::TestWithParam<Reader> {};

TEST_P(Reference, OtherProgramsReadTheSameVolume) {
  if (!std::filesystem::exists("/usr/bin/python3")) GTEST_SKIP() << "/usr/bin/python3 is missing";
  const Format format = GetParam().format;
  const test::TempFolder folder;
  std::vector<Sample> samples;
  std::vector<json> requests;
  for (int i = 0; i < kFiles; ++i) {
    Random random(static_cast<uint64_t>(5000 + i));
    samples.push_back(format.make(random));
    const auto place = folder / std::to_string(i);
    std::filesystem::create_directory(place);
    for (const auto& [name, content] : samples.back().files) {
      test::write_file(place / name, content);
    }
    const auto step = samples.back().options.time_step;
    requests.push_back({{"path", (place / samples.back().main).string()},
                        {"step", step ? json(*step) : json(nullptr)}});
  }
  const std::vector<json> results = run_reader(format.name, requests);
  ASSERT_FALSE(results.empty());
  if (results[0].contains("absent")) {
    GTEST_SKIP() << results[0]["absent"].get<std::string>() << " is not installed";
  }
  ASSERT_EQ(results.size(), requests.size());
  int compared = 0;
  for (size_t i = 0; i < results.size(); ++i) {
    SCOPED_TRACE("seed " + std::to_string(5000 + i) + ": " + samples[i].text);
    // The reader does not know a spacing of the options.
    if (results[i].contains("skipped") || samples[i].options.spacing) continue;
    ++compared;
    auto volume = import::open_volume(requests[i]["path"].get<std::string>(), samples[i].options);
    ASSERT_TRUE(volume) << volume.error().message;
    const auto values = read_values(*volume->source);
    ASSERT_TRUE(values) << values.error().message;
    EXPECT_EQ(difference(volume->source->header().grid, *values, truth_of(results[i])), "");
  }
  EXPECT_GE(compared, GetParam().min_read);
}

INSTANTIATE_TEST_SUITE_P(Readers, Reference,
                         testing::Values(Reader{{"Dicom", make_dicom}, kFiles},
                                         Reader{{"Tiff", make_tiff}, kFiles / 2},
                                         Reader{{"Nrrd", make_nrrd}, kFiles / 3},
                                         Reader{{"Mrc", make_mrc}, kFiles / 2},
                                         Reader{{"Npy", make_npy}, kFiles / 3},
                                         Reader{{"VtkXml", make_vtk_xml}, kFiles / 4}),
                         [](const auto& reader) { return std::string(reader.param.format.name); });

}  // namespace
}  // namespace isosplat::conformance
