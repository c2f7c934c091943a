#include "tests/conformance/sample.h"
#include "tests/native/dicom_files.h"

// Files whose values are stated only by Real World Value Mapping (PS3.3, C.7.6.16.2.11): integer
// and floating-point parametric maps, enhanced images, and slices with the mapping in the data set.
namespace isosplat::conformance {
namespace {

using test::dicom_numbers;
using test::dicom_sequence;
using test::dicom_text;
using test::dicom_u16;
using test::DicomItem;

class Maker {
 public:
  explicit Maker(Random& random) : random_(random) {}

  Sample make() {
    Truth& truth = sample_.truth;
    truth.sizes = {random_.between(2, 5), random_.between(2, 5), random_.between(2, 5)};
    truth.steps = choose_steps(random_);
    truth.origin = choose_place(random_);
    is_float_ = random_.chance(25);
    is_signed_ = !is_float_ && random_.chance(30);
    place_ = random_.between(0, 2);  // in each frame, in the shared groups, in the data set
    is_partial_ = !is_float_ && random_.chance(20);
    has_other_ = random_.chance(20);
    const bool differs = place_ == 0 && random_.chance(40);
    for (int z = 0; z < slices(); ++z) {
      const double slope = random_.one_of({0.001, 0.5, 1.53455, -2.0});
      lines_.push_back(
          {differs || z == 0 ? slope : lines_[0].slope,
           z == 0 || differs ? random_.one_of({-5.0, 0.0, 100.25}) : lines_[0].intercept});
      std::vector<double> stored;
      for (int i = 0; i < columns() * rows(); ++i) {
        stored.push_back(10 + i + 25 * z - (is_signed_ ? 60 : 0) + (is_float_ ? 0.25 : 0));
        truth.values.push_back(lines_.back().intercept + lines_.back().slope * stored.back());
      }
      stored_.push_back(std::move(stored));
    }
    sample_.must_be_noted = is_partial_ || has_other_;
    for (const Line& line : lines_) {
      if (line.slope != lines_[0].slope || line.intercept != lines_[0].intercept) {
        sample_.must_be_noted = true;
      }
    }
    write();
    sample_.text = fmt::format("{}, mapping of {}{}", is_float_ ? "floats" : "integers",
                               place_ == 0   ? "each frame"
                               : place_ == 1 ? "all frames"
                                             : "the data set",
                               has_other_ ? ", and another" : "");
    return std::move(sample_);
  }

 private:
  struct Line {
    double slope = 1, intercept = 0;
  };

  int columns() const { return sample_.truth.sizes[0]; }
  int rows() const { return sample_.truth.sizes[1]; }
  int slices() const { return sample_.truth.sizes[2]; }

  static test::DicomValue numbers(const std::vector<double>& values) {
    return dicom_text("DS", test::dicom_decimals(values));
  }

  DicomItem mapping_item(const Line& line, const char* label) const {
    DicomItem item{{0x004008ea, dicom_sequence({{{0x00080100, dicom_text("SH", "1")}}})},
                   {0x00409210, dicom_text("SH", label)},
                   {0x00409224, dicom_numbers("FD", std::vector{line.intercept})},
                   {0x00409225, dicom_numbers("FD", std::vector{line.slope})}};
    if (is_float_) {
      item[0x00409213] = dicom_numbers("FD", std::vector{1e30});
      item[0x00409214] = dicom_numbers("FD", std::vector{-1e30});
    } else if (is_signed_) {
      item[0x00409211] =
          dicom_numbers("SS", std::vector<int16_t>{is_partial_ ? int16_t{4095} : int16_t{32767}});
      item[0x00409216] = dicom_numbers("SS", std::vector<int16_t>{-32768});
    } else {
      item[0x00409211] = dicom_u16(is_partial_ ? 4095 : 65535);
      item[0x00409216] = dicom_u16(0);
    }
    return item;
  }

  test::DicomValue mapping(int z) const {
    const Line& line = lines_[static_cast<size_t>(z)];
    std::vector<DicomItem> items{mapping_item(line, "first")};
    if (has_other_) items.push_back(mapping_item({line.slope * 3, line.intercept + 1}, "second"));
    return dicom_sequence(items);
  }

  void write() {
    const auto& steps = sample_.truth.steps;
    const Vec3d row = steps[0] * (1 / length(steps[0])), column = steps[1] * (1 / length(steps[1]));
    DicomItem d;
    d[0x00080016] = dicom_text("UI", "1.2.840.10008.5.1.4.1.1.30");
    d[0x00080018] = dicom_text("UI", "1.2.3.4.1");
    d[0x00080060] = dicom_text("CS", "MR");
    d[0x0020000e] = dicom_text("UI", "1.2.3.4");
    d[0x00280002] = dicom_u16(1);
    d[0x00280004] = dicom_text("CS", "MONOCHROME2");
    d[0x00280008] = dicom_text("IS", std::to_string(slices()));
    d[0x00280010] = dicom_u16(static_cast<uint16_t>(rows()));
    d[0x00280011] = dicom_u16(static_cast<uint16_t>(columns()));
    d[0x00280100] = d[0x00280101] = dicom_u16(is_float_ ? 32 : 16);
    d[0x00280102] = dicom_u16(is_float_ ? 31 : 15);
    d[0x00280103] = dicom_u16(is_signed_ ? 1 : 0);
    const auto orientation = numbers({row.x, row.y, row.z, column.x, column.y, column.z});
    const auto spacing = numbers({length(steps[1]), length(steps[0])});
    DicomItem shared{{0x00209116, dicom_sequence({{{0x00200037, orientation}}})},
                     {0x00289110, dicom_sequence({{{0x00280030, spacing}}})}};
    if (place_ == 1) shared[0x00409096] = mapping(0);
    if (place_ == 2) d[0x00409096] = mapping(0);
    d[0x52009229] = dicom_sequence({shared});
    std::vector<DicomItem> groups;
    std::vector<float> floats;
    std::vector<int16_t> whole;
    for (int z = 0; z < slices(); ++z) {
      const Vec3d p = sample_.truth.origin + steps[2] * z;
      groups.push_back({{0x00209113, dicom_sequence({{{0x00200032, numbers({p.x, p.y, p.z})}}})}});
      if (place_ == 0) groups.back()[0x00409096] = mapping(z);
      for (const double value : stored_[static_cast<size_t>(z)]) {
        floats.push_back(static_cast<float>(value));
        whole.push_back(static_cast<int16_t>(value));
      }
    }
    d[0x52009230] = dicom_sequence(groups);
    if (is_float_) {
      d[0x7fe00008] = dicom_numbers("OF", floats);
    } else {
      d[0x7fe00010] = dicom_numbers("OW", whole);
    }
    sample_.main = "map.dcm";
    sample_.files["map.dcm"] = file_of(d);
    const auto damage = [&](const std::function<void(DicomItem&)>& change) {
      DicomItem changed = d;
      change(changed);
      sample_.damages.push_back(
          [bytes = file_of(changed)](auto& files) { files["map.dcm"] = bytes; });
    };
    damage([&](DicomItem& i) { mapping_of(i).erase(0x00409225); });
    damage(
        [&](DicomItem& i) { mapping_of(i)[0x00409225] = dicom_numbers("FD", std::vector{0.0}); });
    damage([](DicomItem& i) { i[0x52009230].items.pop_back(); });
    damage([](DicomItem& i) { i[0x52009230].items[0].erase(0x00209113); });
  }

  /// The only mapping of the first frame; further ones are removed.
  DicomItem& mapping_of(DicomItem& d) const {
    test::DicomValue& sequence = place_ == 0   ? d[0x52009230].items[0][0x00409096]
                                 : place_ == 1 ? d[0x52009229].items[0][0x00409096]
                                               : d[0x00409096];
    sequence.items.resize(1);
    return sequence.items[0];
  }

  std::string file_of(const DicomItem& d) const {
    const auto syntaxes = {test::DicomSyntax{}, test::implicit_little(), test::explicit_big(),
                           test::deflated_little()};
    return test::DicomWriter(*(syntaxes.begin() + (columns() + rows()) % 4)).file(d);
  }

  Random& random_;
  Sample sample_;
  bool is_float_ = false, is_signed_ = false, is_partial_ = false, has_other_ = false;
  int place_ = 0;
  std::vector<Line> lines_;                  ///< by slice
  std::vector<std::vector<double>> stored_;  ///< by slice
};

}  // namespace

Sample make_dicom_mapping(Random& random) {
  return Maker(random).make();
}

}  // namespace isosplat::conformance
