#include "tests/conformance/sample.h"
#include "tests/native/dicom_siemens.h"

// Siemens mosaics, alone or as the times of a folder, in the layout that dicom_siemens.h describes.
namespace isosplat::conformance {
namespace {

using test::dicom_text;
using test::dicom_u16;
using test::DicomItem;

class Maker {
 public:
  explicit Maker(Random& random) : random_(random) {}

  Sample make() {
    Truth& truth = sample_.truth;
    truth.sizes = {random_.between(2, 5), random_.between(2, 5), random_.between(2, 11)};
    truth.steps = choose_steps(random_);
    truth.origin = choose_place(random_);
    while (across_ * across_ < truth.sizes[2]) ++across_;
    is_sv10_ = random_.chance(60);
    block_ = static_cast<uint32_t>(random_.between(0x10, 0x14));
    states_distance_ = random_.chance(70);
    const int times = random_.chance(40) ? random_.between(2, 3) : 1;
    const int step = random_.between(0, times - 1);
    for (int t = 0; t < times; ++t) {
      const DicomItem d = mosaic(t, t == step);
      const std::string name = fmt::format("IM{}.dcm", (7 * t) % 3);
      sample_.files[name] = file_of(d);
      if (t == step) add_damages(name, d);
    }
    if (times > 1) {
      sample_.options.time_step = step;
    } else {
      sample_.main = sample_.files.begin()->first;
    }
    sample_.try_allowances = times == 1;  // without a file, the times are numbered differently
    sample_.must_be_noted = times > 1 || !states_distance_;
    sample_.text = fmt::format("{} slices, {} times, {}", truth.sizes[2], times,
                               is_sv10_ ? "SV10" : "before SV10");
    return std::move(sample_);
  }

 private:
  int columns() const { return sample_.truth.sizes[0]; }
  int rows() const { return sample_.truth.sizes[1]; }
  int slices() const { return sample_.truth.sizes[2]; }

  static test::DicomValue numbers(const std::vector<double>& values) {
    return dicom_text("DS", test::dicom_decimals(values));
  }

  DicomItem mosaic(int time, bool is_chosen) {
    const auto& steps = sample_.truth.steps;
    const double dx = length(steps[0]), dy = length(steps[1]), dz = length(steps[2]);
    const Vec3d row = steps[0] * (1 / dx), column = steps[1] * (1 / dy),
                normal = steps[2] * (1 / dz);
    std::vector<std::vector<uint16_t>> tiles;
    for (int z = 0; z < slices(); ++z) {
      std::vector<uint16_t> tile;
      for (int i = 0; i < columns() * rows(); ++i) {
        tile.push_back(static_cast<uint16_t>(10 + i + 25 * z + 500 * time));
        if (is_chosen) sample_.truth.values.push_back(tile.back());
      }
      tiles.push_back(std::move(tile));
    }
    // The corner of an imaginary slice that is as large as the mosaic, and has the centre of the
    // first slice.
    const Vec3d corner = sample_.truth.origin - steps[0] * ((across_ - 1) * columns() / 2.0) -
                         steps[1] * ((across_ - 1) * rows() / 2.0);
    DicomItem d;
    d[0x00080008] = dicom_text("CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC");
    d[0x00080016] = dicom_text("UI", "1.2.840.10008.5.1.4.1.1.4");
    d[0x00080018] = dicom_text("UI", fmt::format("1.2.3.4.{}", time + 1));
    d[0x00080060] = dicom_text("CS", "MR");
    d[0x00180050] = numbers({dz});
    if (states_distance_) d[0x00180088] = numbers({dz});
    d[0x0020000e] = dicom_text("UI", "1.2.3.4");
    d[0x00200012] = dicom_text("IS", std::to_string(time + 1));
    d[0x00200032] = numbers({corner.x, corner.y, corner.z});
    d[0x00200037] = numbers({row.x, row.y, row.z, column.x, column.y, column.z});
    d[0x00280002] = dicom_u16(1);
    d[0x00280004] = dicom_text("CS", "MONOCHROME2");
    d[0x00280010] = dicom_u16(static_cast<uint16_t>(across_ * rows()));
    d[0x00280011] = dicom_u16(static_cast<uint16_t>(across_ * columns()));
    d[0x00280030] = numbers({dy, dx});
    d[0x00280100] = dicom_u16(16);
    d[0x00280101] = dicom_u16(12);
    d[0x00280102] = dicom_u16(11);
    d[0x00280103] = dicom_u16(0);
    d[0x7fe00010] = test::dicom_numbers("OW", test::tiled(tiles, columns(), rows()));
    add_header(d, slices(), normal);
    return d;
  }

  void add_header(DicomItem& d, int slices, Vec3d normal) const {
    test::add_csa(d, test::csa_of_mosaic(slices, {normal.x, normal.y, normal.z}, is_sv10_), block_);
  }

  std::string file_of(const DicomItem& d) const {
    const auto syntax = columns() % 2 ? test::DicomSyntax{} : test::implicit_little();
    return test::DicomWriter(syntax).file(d);
  }

  void add_damages(const std::string& name, const DicomItem& d) {
    const auto damage = [&](const std::function<void(DicomItem&)>& change) {
      DicomItem changed = d;
      change(changed);
      sample_.damages.push_back(
          [name, bytes = file_of(changed)](auto& files) { files[name] = bytes; });
    };
    const Vec3d normal = sample_.truth.steps[2] * (1 / length(sample_.truth.steps[2]));
    const Vec3d row = sample_.truth.steps[0] * (1 / length(sample_.truth.steps[0]));
    damage([&](DicomItem& i) { i.erase(0x00290010 | (block_ << 8)); });
    damage([&](DicomItem& i) { i.erase(0x00290000 | block_); });
    damage([&](DicomItem& i) { add_header(i, 10000, normal); });
    damage([&](DicomItem& i) { add_header(i, slices(), row); });
    damage([](DicomItem& i) { i.erase(0x00200032); });
    damage([](DicomItem& i) { i.erase(0x00200037); });
    damage([](DicomItem& i) { i.erase(0x00280030); });
    damage([](DicomItem& i) { i.erase(0x7fe00010); });
    damage([&](DicomItem& i) {
      i[0x00280010] = dicom_u16(static_cast<uint16_t>(2 * across_ * rows()));
    });
  }

  Random& random_;
  Sample sample_;
  int across_ = 1;
  bool is_sv10_ = true, states_distance_ = true;
  uint32_t block_ = 0x10;
};

}  // namespace

Sample make_dicom_mosaic(Random& random) {
  return Maker(random).make();
}

}  // namespace isosplat::conformance
