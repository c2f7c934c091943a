#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "tests/conformance/compare.h"
#include "tests/conformance/sample.h"
#include "tests/native/test_files.h"

// Tests the rule of the importers: a reader returns the right volume, or the right volume with a
// note about each assumption, or an error. It never returns a wrong volume.
//
//   ISOSPLAT_CONFORMANCE_CASES   files of each format (60)
//   ISOSPLAT_CONFORMANCE_SEED    the first seed (1); a failure names the seed of its file
namespace isosplat::conformance {

std::string gzipped(const std::string& bytes, bool zlib) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, zlib ? 15 : 31, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, bytes.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

namespace {

using Files = std::map<std::string, std::string>;

int number_of(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text ? std::atoi(text) : otherwise;
}

struct Outcome {
  std::optional<Error> error;
  std::string difference;  ///< from the truth, if there is no error
  std::vector<std::string> notes;
};

Outcome open_sample(const Sample& sample, const Files& files, const import::ImportOptions& options,
                    bool may_lack = false) {
  const test::TempFolder folder;
  for (const auto& [name, content] : files) test::write_file(folder / name, content);
  auto volume =
      import::open_volume(sample.main.empty() ? folder.path() : folder / sample.main, options);
  if (!volume) return {volume.error(), {}, {}};
  const auto values = read_values(*volume->source);
  if (!values) return {values.error(), {}, volume->notes};
  return {{},
          difference(volume->source->header().grid, *values, sample.truth, may_lack),
          volume->notes};
}

void expect_sane(const Error& error) {
  EXPECT_EQ(error.message.find('\n'), std::string::npos) << error.message;
  EXPECT_GT(error.message.size(), 20u);
}

/// A damaged sample must be read correctly or be an error. With all allowances, the remaining
/// voxels must be right, and a note must report the missing data.
void expect_rule(const Sample& sample, const Files& files, bool try_allowed) {
  const Outcome outcome = open_sample(sample, files, sample.options);
  if (outcome.error) expect_sane(*outcome.error);
  EXPECT_EQ(outcome.error ? "" : outcome.difference, "") << "read without an error";
  if (!try_allowed || !sample.try_allowances) return;
  import::ImportOptions options = sample.options;
  for (const import::AllowanceFlag& flag : import::kAllowances) options.allowed.add(flag.allowance);
  const Outcome allowed = open_sample(sample, files, options, true);
  if (allowed.error) return expect_sane(*allowed.error);
  EXPECT_EQ(allowed.difference, "") << "read with all allowances";
  const bool is_whole = open_sample(sample, files, options).difference.empty();
  EXPECT_TRUE(is_whole || !allowed.notes.empty()) << "no note reports the missing data";
}

void check_sample(const Sample& sample, Random& random) {
  const Outcome outcome = open_sample(sample, sample.files, sample.options);
  ASSERT_FALSE(outcome.error) << outcome.error->message;
  ASSERT_EQ(outcome.difference, "");
  EXPECT_FALSE(sample.must_be_noted && outcome.notes.empty()) << "no note reports the assumption";

  for (const std::string& part : sample.false_notes) {
    for (const std::string& note : outcome.notes) {
      EXPECT_EQ(note.find(part), std::string::npos) << "denies what is in the file: " << note;
    }
  }
  if (sample.needs_choice) {
    import::ImportOptions options;
    options.spacing = sample.options.spacing;
    EXPECT_TRUE(open_sample(sample, sample.files, options).error) << "read without a choice";
  }

  for (const auto& damage : sample.damages) {
    SCOPED_TRACE("contradiction " + std::to_string(&damage - sample.damages.data()));
    Files files = sample.files;
    damage(files);
    expect_rule(sample, files, false);
  }
  std::vector<std::string> names;
  for (const auto& [name, content] : sample.files) {
    if (!sample.open_ended.contains(name)) names.push_back(name);
  }
  if (names.empty()) return;
  for (int i = 0; i < 3; ++i) {
    const std::string& name = names[random.between(0, static_cast<int>(names.size()) - 1)];
    Files files = sample.files;
    std::string& content = files[name];
    const int size = static_cast<int>(content.size());
    // At a random position, near the end, and before the last byte.
    const int cut = i == 0   ? random.between(0, size - 1)
                    : i == 1 ? random.between(size / 2, size - 1)
                             : size - 1;
    if (sample.whole_at.contains(cut) || sample.whole_at.contains(cut + 1)) continue;
    content.resize(static_cast<size_t>(cut));
    SCOPED_TRACE(name + " cut to " + std::to_string(cut) + " of " + std::to_string(size) +
                 " bytes");
    expect_rule(sample, files, true);
  }
  if (!sample.may_be_longer) {
    Files files = sample.files;
    files[names[random.between(0, static_cast<int>(names.size()) - 1)]] += "0123456789abcdef";
    SCOPED_TRACE("16 extra bytes");
    expect_rule(sample, files, false);
  }
  for (const std::string& name : sample.removable) {
    Files files = sample.files;
    files.erase(name);
    SCOPED_TRACE(name + " is missing");
    EXPECT_TRUE(open_sample(sample, files, sample.options).error);
    expect_rule(sample, files, true);
  }
}

class Conformance : public testing::TestWithParam<Format> {};

TEST_P(Conformance, TheRightVolumeOrAnError) {
  const int cases = number_of("ISOSPLAT_CONFORMANCE_CASES", 60);
  const int first = number_of("ISOSPLAT_CONFORMANCE_SEED", 1);
  for (int i = 0; i < cases; ++i) {
    Random random(static_cast<uint64_t>(first + i));
    const Sample sample = GetParam().make(random);
    SCOPED_TRACE("seed " + std::to_string(first + i) + ": " + sample.text);
    check_sample(sample, random);
    if (HasFailure() && cases > 100) break;
  }
}

const Format kFormats[] = {{"Nrrd", make_nrrd},
                           {"MetaImage", make_meta_image},
                           {"Nifti", make_nifti},
                           {"Mgh", make_mgh},
                           {"Netcdf", make_netcdf},
                           {"Mrc", make_mrc},
                           {"Npy", make_npy},
                           {"Npz", make_npz},
                           {"Hdf5", make_hdf5},
                           {"Vtk", make_vtk},
                           {"VtkXml", make_vtk_xml},
                           {"Cube", make_cube},
                           {"Vasp", make_vasp},
                           {"Xsf", make_xsf},
                           {"OpenDx", make_dx},
                           {"Tiff", make_tiff},
                           {"TiffSeries", make_tiff_series},
                           {"Raw", make_raw},
                           {"Dicom", make_dicom},
                           {"DicomMapping", make_dicom_mapping},
                           {"DicomMosaic", make_dicom_mosaic},
                           {"DicomSegments", make_dicom_segments}};

INSTANTIATE_TEST_SUITE_P(Formats, Conformance, testing::ValuesIn(kFormats),
                         [](const auto& format) { return std::string(format.param.name); });

}  // namespace
}  // namespace isosplat::conformance
