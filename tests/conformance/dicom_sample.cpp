#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/conformance/sample.h"
#include "tests/native/dicom_files.h"

// Written from the DICOM standard: PS3.3 (meaning of elements), PS3.5 (encoding), PS3.10 (files).
namespace isosplat::conformance {
namespace {

using test::DicomItem;
using test::DicomSyntax;
using test::DicomValue;
using test::DicomWriter;

/// A decimal string has at most 16 characters (PS3.5, 6.2).
std::string decimals(const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) {
    text += fmt::format("{}{:.10g}", text.empty() ? "" : "\\", number);
  }
  return text;
}

DicomValue decimal_value(const std::vector<double>& numbers) {
  return test::dicom_text("DS", decimals(numbers));
}

/// RLE as in PS3.5, Annex G, with literal runs only: one segment for each byte of a pixel, the most
/// significant byte first.
std::string run_lengths(const std::string& little_endian, size_t pixel, size_t row) {
  std::string segments;
  std::vector<uint32_t> header(16, 0);
  header[0] = static_cast<uint32_t>(pixel);
  for (size_t byte = pixel; byte-- > 0;) {
    header[pixel - byte] = static_cast<uint32_t>(64 + segments.size());
    std::string plane;
    for (size_t i = byte; i < little_endian.size(); i += pixel) plane += little_endian[i];
    for (size_t at = 0; at < plane.size(); at += row) {  // no run crosses the end of a row
      segments += static_cast<char>(row - 1);
      segments += plane.substr(at, row);
    }
    if (segments.size() % 2) segments += '\0';
  }
  return test::bytes_of(header) + segments;
}

/// How pixels are stored.
struct Pixels {
  int allocated = 16, stored = 12, high_bit = 11;
  bool is_signed = false;
  bool is_rle = false;
  bool has_other_bits = false;  ///< the bits beside the stored ones are set

  size_t bytes() const { return static_cast<size_t>(allocated) / 8; }

  std::string encode(const std::vector<int64_t>& stored_values) const {
    const uint64_t mask = (uint64_t{1} << stored) - 1;
    const int below = high_bit + 1 - stored;
    std::string out;
    for (const int64_t value : stored_values) {
      uint64_t word = (static_cast<uint64_t>(value) & mask) << below;
      if (has_other_bits) word |= ~(mask << below);
      out.append(reinterpret_cast<const char*>(&word), bytes());
    }
    return out;
  }

  /// The pixel element of several frames.
  DicomValue element(const std::vector<std::string>& frames, size_t columns) const {
    if (is_rle) {
      std::vector<std::string> fragments;
      for (const std::string& frame : frames) {
        fragments.push_back(run_lengths(frame, bytes(), columns));
      }
      return test::dicom_fragments(fragments);
    }
    std::string all;
    for (const std::string& frame : frames) all += frame;
    if (all.size() % 2) all += '\0';
    return {allocated == 8 ? "OB" : "OW", all, bytes(), {}};
  }
};

Pixels choose_pixels(Random& random) {
  Pixels p;
  p.allocated = random.one_of({8, 16, 16, 16, 32});
  p.is_signed = random.chance(40);
  p.stored = p.allocated == 8 ? 8 : random.between(12, p.allocated);
  p.high_bit = random.between(p.stored - 1, p.allocated - 1);
  p.has_other_bits = random.chance(20);
  return p;
}

/// Writes one volume as DICOM files.
class Maker {
 public:
  explicit Maker(Random& random) : random_(random), pixels_(choose_pixels(random)) {}

  Sample make() {
    choose_values();
    choose_geometry();
    choose_syntax();
    const int kind = random_.between(0, 9);
    if (kind < 5) make_folder();
    if (kind >= 5 && kind < 8) make_enhanced();
    if (kind == 8) make_dose();
    if (kind == 9) make_nuclear();
    sample_.text +=
        fmt::format(", {} bits of {}{}, slope {}{}{}, {}", pixels_.stored, pixels_.allocated,
                    pixels_.is_signed ? " signed" : "", slopes_[0], differ_ ? " and others" : "",
                    is_inverse_ ? ", MONOCHROME1" : "", pixels_.is_rle ? "RLE" : syntax_.uid);
    return std::move(sample_);
  }

 private:
  int columns() const { return sample_.truth.sizes[0]; }
  int rows() const { return sample_.truth.sizes[1]; }
  int slices() const { return sample_.truth.sizes[2]; }

  /// Values are linear in x, y and z, so that interpolation reproduces missing slices.
  void choose_values() {
    Truth& truth = sample_.truth;
    for (int& size : truth.sizes) size = random_.between(2, 6);
    differ_ = pixels_.stored >= 12 && random_.chance(25);
    const double unit = random_.one_of({1.0, 1.0, 0.5, 0.001, 3.0});
    intercept_ = random_.one_of({0.0, 0.0, -1024.0, 12.5});
    for (int z = 0; z < slices(); ++z) {
      const int factor = differ_ ? random_.one_of({1, 2, 4}) : 1;
      slopes_.push_back(unit * factor);
      std::vector<int64_t> stored_values;
      for (int y = 0; y < rows(); ++y) {
        for (int x = 0; x < columns(); ++x) {
          const int64_t number = 10 + x + 6 * y + 36 * z - (pixels_.is_signed ? 120 : 0);
          stored_values.push_back(differ_ ? number * 4 / factor : number);
          truth.values.push_back(intercept_ +
                                 unit * static_cast<double>(differ_ ? number * 4 : number));
        }
      }
      stored_values_.push_back(std::move(stored_values));
    }
    has_rescaling_ = differ_ || unit != 1 || intercept_ != 0 || random_.chance(30);
    is_inverse_ = random_.chance(15);
    sample_.must_be_noted =
        is_inverse_ || (differ_ && std::set(slopes_.begin(), slopes_.end()).size() > 1);
  }

  void choose_geometry() {
    Truth& truth = sample_.truth;
    truth.steps = choose_steps(random_);
    truth.origin = choose_place(random_);
    spacing_ = {length(truth.steps[0]), length(truth.steps[1]), length(truth.steps[2])};
    row_ = truth.steps[0] * (1 / spacing_.x);
    column_ = truth.steps[1] * (1 / spacing_.y);
  }

  void tilt_gantry() {
    sample_.truth.steps[2] =
        sample_.truth.steps[2] + column_ * (spacing_.z * random_.real(0.1, 0.5));
    sample_.must_be_noted = true;
  }

  void choose_syntax() {
    switch (random_.between(0, 9)) {
      case 0:
      case 1:
        syntax_ = test::implicit_little();
        break;
      case 2:
        syntax_ = test::explicit_big();
        break;
      case 3:
        syntax_ = test::deflated_little();
        break;
      case 4:
        if (pixels_.allocated <= 16 && !pixels_.has_other_bits) {
          pixels_.is_rle = true;
          syntax_.uid = "1.2.840.10008.1.2.5";
        }
        break;
    }
    syntax_.undefined_lengths = random_.chance(50);
  }

  Vec3d position(int z) const { return sample_.truth.origin + sample_.truth.steps[2] * z; }
  DicomValue position_value(int z) const {
    const Vec3d p = position(z);
    return decimal_value({p.x, p.y, p.z});
  }
  DicomValue orientation_value() const {
    return decimal_value({row_.x, row_.y, row_.z, column_.x, column_.y, column_.z});
  }
  DicomValue pixel_spacing_value() const { return decimal_value({spacing_.y, spacing_.x}); }
  std::string frame(int z) const { return pixels_.encode(stored_values_[static_cast<size_t>(z)]); }

  DicomItem common(const std::string& modality, const std::string& sop_class) const {
    DicomItem d;
    d[0x00080016] = test::dicom_text("UI", sop_class);
    d[0x00080060] = test::dicom_text("CS", modality);
    d[0x00100010] = test::dicom_text("PN", "Doe^Jane");
    d[0x0020000d] = test::dicom_text("UI", "1.2.3");
    d[0x0020000e] = test::dicom_text("UI", "1.2.3.4");
    d[0x00280002] = test::dicom_u16(1);
    d[0x00280004] = test::dicom_text("CS", is_inverse_ ? "MONOCHROME1" : "MONOCHROME2");
    d[0x00280010] = test::dicom_u16(static_cast<uint16_t>(rows()));
    d[0x00280011] = test::dicom_u16(static_cast<uint16_t>(columns()));
    d[0x00280100] = test::dicom_u16(static_cast<uint16_t>(pixels_.allocated));
    d[0x00280101] = test::dicom_u16(static_cast<uint16_t>(pixels_.stored));
    d[0x00280102] = test::dicom_u16(static_cast<uint16_t>(pixels_.high_bit));
    d[0x00280103] = test::dicom_u16(pixels_.is_signed ? 1 : 0);
    return d;
  }

  void set_rescaling(DicomItem& d, int z) const {
    if (!has_rescaling_) return;
    d[0x00281052] = decimal_value({intercept_});
    d[0x00281053] = decimal_value({slopes_[static_cast<size_t>(z)]});
  }

  DicomItem slice(int z) const {
    DicomItem d = common("CT", "1.2.840.10008.5.1.4.1.1.2");
    d[0x00080018] = test::dicom_text("UI", fmt::format("1.2.3.4.{}", z + 1));
    d[0x00200032] = position_value(z);
    d[0x00200037] = orientation_value();
    d[0x00280030] = pixel_spacing_value();
    set_rescaling(d, z);
    d[0x7fe00010] = pixels_.element({frame(z)}, static_cast<size_t>(columns()));
    return d;
  }

  std::string file_of(const DicomItem& d) const { return DicomWriter(syntax_).file(d); }

  /// A change of one file that contradicts the other files.
  void add_damage(const std::string& name, DicomItem d,
                  const std::function<void(DicomItem&)>& change) {
    change(d);
    sample_.damages.push_back([name, bytes = file_of(d)](auto& files) { files[name] = bytes; });
  }

  /// The bytes of a file up to an element, as if this element and all later ones were missing.
  std::string cut_before(DicomItem d, uint32_t tag) const {
    d.erase(d.lower_bound(tag), d.end());
    return file_of(d);
  }

  void make_folder() {
    if (random_.chance(20)) tilt_gantry();
    if (random_.chance(40)) syntax_.has_prefix = syntax_.uid != "1.2.840.10008.1.2";
    const char* extension = !syntax_.has_prefix ? ".dcm" : random_.one_of({".dcm", "", ".IMA"});
    std::vector<int> numbers(static_cast<size_t>(slices()));
    std::iota(numbers.begin(), numbers.end(), 100);
    for (size_t i = numbers.size(); i-- > 1;) {
      std::swap(numbers[i], numbers[static_cast<size_t>(random_.between(0, static_cast<int>(i)))]);
    }
    const auto name_of = [&](int z) {
      return fmt::format("IM{}{}", numbers[static_cast<size_t>(z)], extension);
    };
    // Instance numbers may be missing or arbitrary.
    const int instances = random_.between(0, 2);
    const int times = random_.chance(25) ? random_.between(2, 3) : 1;
    const int step = random_.between(0, times - 1);
    const uint32_t told_by = random_.one_of({0x00200100u, 0x00180081u, 0x00200012u});
    if (times > 1) {
      sample_.options.time_step = step;
      sample_.must_be_noted = true;
    }
    const auto make_slice = [&](int z) {
      DicomItem d = slice(z);
      if (instances == 1) d[0x00200013] = test::dicom_text("IS", std::to_string(z + 1));
      if (instances == 2) {
        d[0x00200013] = test::dicom_text("IS", std::to_string(numbers[static_cast<size_t>(z)]));
      }
      if (times > 1) {
        d[told_by] = test::dicom_text(told_by == 0x00180081u ? "DS" : "IS", std::to_string(step));
      }
      return d;
    };
    for (int z = 0; z < slices(); ++z) {
      sample_.files[name_of(z)] = file_of(make_slice(z));
      if (slices() > 3 && z > 0 && z + 1 < slices()) sample_.removable.insert(name_of(z));
      for (int t = 0; t < times; ++t) {
        if (t == step) continue;
        DicomItem d = make_slice(z);
        d[0x00080018] = test::dicom_text("UI", fmt::format("1.2.3.5.{}.{}", t, z));
        d[told_by] = test::dicom_text(told_by == 0x00180081u ? "DS" : "IS", std::to_string(t));
        const std::vector<int64_t> other(stored_values_[0].size(), 3);
        d[0x7fe00010] = pixels_.element({pixels_.encode(other)}, static_cast<size_t>(columns()));
        sample_.files[fmt::format("IM{}_{}{}", z, t, extension)] = file_of(d);
      }
    }
    sample_.text = fmt::format("a folder, {} times", times);
    add_strangers();
    damage_slices(make_slice, name_of);
  }

  /// Files in the folder that do not belong to the volume.
  void add_strangers() {
    const auto add = [&](const std::string& name, const std::string& bytes) {
      sample_.files[name] = bytes;
      sample_.open_ended.insert(name);
      sample_.must_be_noted = true;
    };
    if (random_.chance(15)) add("readme.txt", "exported on a Monday");
    if (random_.chance(15)) add("shot.tif", std::string("II*\0", 4) + std::string(20, 'x'));
    if (random_.chance(15)) {
      DicomItem report;
      report[0x00080016] = test::dicom_text("UI", "1.2.840.10008.5.1.4.1.1.88.11");
      report[0x00080060] = test::dicom_text("CS", "SR");
      report[0x0020000e] = test::dicom_text("UI", "1.2.3.9");
      add("SR1", DicomWriter(DicomSyntax{}).file(report));
    }
    if (random_.chance(15)) {  // a screenshot
      DicomItem shot = slice(0);
      shot[0x00080018] = test::dicom_text("UI", "1.2.3.7.1");
      shot[0x0020000e] = test::dicom_text("UI", "1.2.3.7");
      shot[0x00280002] = test::dicom_u16(3);
      shot[0x00280004] = test::dicom_text("CS", "RGB");
      add("shot.dcm", DicomWriter(DicomSyntax{}).file(shot));
    }
    if (random_.chance(20)) {  // one slice of another series, at another position
      DicomItem other = slice(0);
      other[0x00080018] = test::dicom_text("UI", "1.2.3.8.1");
      other[0x0020000e] = test::dicom_text("UI", "1.2.3.8");
      other[0x00200032] = decimal_value({7, 8, 9});
      add("other.dcm", file_of(other));
      sample_.open_ended.erase("other.dcm");
    }
    if (random_.chance(15)) {
      DicomItem localizer = slice(0);
      localizer[0x00080008] = test::dicom_text("CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
      localizer[0x00080018] = test::dicom_text("UI", "1.2.3.4.900");
      localizer[0x00200037] = decimal_value({0, 1, 0, 0, 0, -1});
      add("scout.dcm", file_of(localizer));
      sample_.open_ended.erase("scout.dcm");
    }
  }

  template <class MakeSlice, class NameOf>
  void damage_slices(const MakeSlice& make_slice, const NameOf& name_of) {
    const int z = random_.between(0, slices() - 1), other = z > 0 ? z - 1 : 1;
    const std::string name = name_of(z);
    const DicomItem d = make_slice(z);
    const auto damage = [&](const auto& change) { add_damage(name, d, change); };
    damage([&](DicomItem& i) { i[0x00200032] = position_value(other); });
    damage([&](DicomItem& i) { i[0x00200032] = test::dicom_text("DS", "0\\nan\\0"); });
    damage([&](DicomItem& i) { i[0x00200032] = decimal_value({1, 2}); });
    damage([&](DicomItem& i) { i.erase(0x00200032); });
    damage([&](DicomItem& i) {
      const Vec3d normal = cross(row_, column_);
      const Vec3d c = column_ * std::cos(0.35) + normal * std::sin(0.35);
      i[0x00200037] = decimal_value({row_.x, row_.y, row_.z, c.x, c.y, c.z});
    });
    damage([&](DicomItem& i) { i[0x00280030] = decimal_value({spacing_.y * 1.5, spacing_.x}); });
    damage(
        [&](DicomItem& i) { i[0x00280010] = test::dicom_u16(static_cast<uint16_t>(rows() + 1)); });
    damage([&](DicomItem& i) { i[0x00281053] = decimal_value({0}); });
    damage([&](DicomItem& i) {
      i[0x00080018] = test::dicom_text("UI", fmt::format("1.2.3.4.{}", other + 1));
    });
    if (slices() > 2) {
      // A shift between two slices may be a gantry tilt; at least three slices show that it is not.
      damage([&](DicomItem& i) {
        const Vec3d p = position(z) + row_ * (2 * spacing_.x) + column_ * spacing_.y;
        i[0x00200032] = decimal_value({p.x, p.y, p.z});
      });
      damage([&](DicomItem& i) {
        const Vec3d p = position(z) + cross(row_, column_) * (0.3 * spacing_.z);
        i[0x00200032] = decimal_value({p.x, p.y, p.z});
      });
    }
    // Truncates between elements, where the file's structure is valid.
    for (const uint32_t tag : {0x7fe00010u, 0x00280010u, 0x00200032u, 0x00080016u}) {
      if (!syntax_.has_prefix && tag == 0x00080016u) continue;  // an empty file, as below
      sample_.damages.push_back(
          [name, bytes = cut_before(d, tag)](auto& files) { files[name] = bytes; });
    }
    sample_.damages.push_back([name](auto& files) { files[name].clear(); });
    sample_.damages.push_back([name](auto& files) { files[name].assign(100, '\0'); });
  }

  /// One file with functional groups, with frames in any order.
  void make_enhanced() {
    if (random_.chance(20)) tilt_gantry();
    std::vector<int> order(static_cast<size_t>(slices()));
    std::iota(order.begin(), order.end(), 0);
    for (size_t i = order.size(); i-- > 1;) {
      std::swap(order[i], order[static_cast<size_t>(random_.between(0, static_cast<int>(i)))]);
    }
    const bool shared_orientation = random_.chance(50), shared_measures = random_.chance(50);
    DicomItem d = common("CT", "1.2.840.10008.5.1.4.1.1.2.1");
    d[0x00080018] = test::dicom_text("UI", "1.2.3.4.1");
    d[0x00280008] = test::dicom_text("IS", std::to_string(slices()));
    DicomItem shared;
    const DicomValue orientation = test::dicom_sequence({{{0x00200037, orientation_value()}}});
    const DicomValue measures = test::dicom_sequence({{{0x00280030, pixel_spacing_value()}}});
    if (shared_orientation) shared[0x00209116] = orientation;
    if (shared_measures) shared[0x00289110] = measures;
    d[0x52009229] = test::dicom_sequence({shared});
    std::vector<DicomItem> groups;
    std::vector<std::string> frames;
    for (const int z : order) {
      DicomItem group;
      group[0x00209113] = test::dicom_sequence({{{0x00200032, position_value(z)}}});
      if (!shared_orientation) group[0x00209116] = orientation;
      if (!shared_measures) group[0x00289110] = measures;
      if (has_rescaling_) {
        DicomItem values;
        set_rescaling(values, z);
        group[0x00289145] = test::dicom_sequence({values});
      }
      groups.push_back(std::move(group));
      frames.push_back(frame(z));
    }
    d[0x52009230] = test::dicom_sequence(groups);
    d[0x7fe00010] = pixels_.element(frames, static_cast<size_t>(columns()));
    finish_file(d, "enhanced");

    const auto damage_groups = [&](const std::function<void(std::vector<DicomItem>&)>& change) {
      add_damage("v.dcm", d, [&](DicomItem& i) { change(i[0x52009230].items); });
    };
    const auto which = static_cast<size_t>(random_.between(0, slices() - 1));
    damage_groups(
        [&](auto& g) { g[which][0x00209113] = g[which > 0 ? which - 1 : 1][0x00209113]; });
    damage_groups([&](auto& g) { g[which].erase(0x00209113); });
    damage_groups([&](auto& g) { g.pop_back(); });
    damage_groups([&](auto& g) {
      const Vec3d normal = cross(row_, column_);
      g[which][0x00209116] = test::dicom_sequence(
          {{{0x00200037,
             decimal_value({column_.x, column_.y, column_.z, normal.x, normal.y, normal.z})}}});
    });
  }

  /// A dose grid: offsets along the normal, values from Dose Grid Scaling.
  void make_dose() {
    differ_ = false;
    is_inverse_ = false;
    choose_plain_values(0);
    DicomItem d = common("RTDOSE", "1.2.840.10008.5.1.4.1.1.481.2");
    d[0x00080018] = test::dicom_text("UI", "1.2.3.4.1");
    d[0x00200032] = position_value(0);
    d[0x00200037] = orientation_value();
    d[0x00280008] = test::dicom_text("IS", std::to_string(slices()));
    d[0x00280030] = pixel_spacing_value();
    std::vector<double> offsets;
    std::vector<std::string> frames;
    const double along = dot(sample_.truth.steps[2], cross(row_, column_));
    for (int z = 0; z < slices(); ++z) {
      offsets.push_back(z * along);
      frames.push_back(frame(z));
    }
    d[0x3004000c] = decimal_value(offsets);
    d[0x3004000e] = decimal_value({slopes_[0]});
    d[0x7fe00010] = pixels_.element(frames, static_cast<size_t>(columns()));
    finish_file(d, "dose");
    add_damage("v.dcm", d, [&](DicomItem& i) {
      i[0x3004000c] = decimal_value(std::vector<double>(offsets.begin() + 1, offsets.end()));
    });
    add_damage("v.dcm", d, [&](DicomItem& i) {
      std::vector<double> other = offsets;
      for (double& offset : other) offset += 1234.5;
      i[0x3004000c] = decimal_value(other);
    });
    add_damage("v.dcm", d, [&](DicomItem& i) { i[0x3004000e] = decimal_value({0}); });
  }

  /// A nuclear medicine reconstruction: equal steps, a negative one against the normal.
  void make_nuclear() {
    differ_ = false;
    choose_plain_values(intercept_);
    DicomItem d = common("NM", "1.2.840.10008.5.1.4.1.1.20");
    d[0x00080008] = test::dicom_text("CS", "ORIGINAL\\PRIMARY\\RECON TOMO\\EMISSION");
    d[0x00080018] = test::dicom_text("UI", "1.2.3.4.1");
    d[0x00180088] = decimal_value({dot(sample_.truth.steps[2], cross(row_, column_))});
    d[0x00280008] = test::dicom_text("IS", std::to_string(slices()));
    d[0x00280030] = pixel_spacing_value();
    DicomItem detector{{0x00200032, position_value(0)}, {0x00200037, orientation_value()}};
    d[0x00540022] = test::dicom_sequence({detector});
    set_rescaling(d, 0);
    std::vector<uint16_t> numbers;
    std::vector<std::string> frames;
    for (int z = 0; z < slices(); ++z) {
      numbers.push_back(static_cast<uint16_t>(z + 1));
      frames.push_back(frame(z));
    }
    d[0x00540080] = test::dicom_numbers("US", numbers);
    d[0x7fe00010] = pixels_.element(frames, static_cast<size_t>(columns()));
    finish_file(d, "nuclear medicine");
    add_damage("v.dcm", d, [&](DicomItem& i) {
      std::vector<uint16_t> fewer(numbers.begin() + 1, numbers.end());
      i[0x00540080] = test::dicom_numbers("US", fewer);
    });
    add_damage("v.dcm", d, [&](DicomItem& i) {
      std::vector<uint16_t> twice = numbers;
      twice.back() = twice.front();
      i[0x00540080] = test::dicom_numbers("US", twice);
    });
  }

  /// One slope for all slices, and the given intercept.
  void choose_plain_values(double intercept) {
    const double slope = random_.one_of({1.0, 0.5, 2.5e-5});
    intercept_ = intercept;
    std::fill(slopes_.begin(), slopes_.end(), slope);
    has_rescaling_ = true;
    std::vector<double>& values = sample_.truth.values;
    values.clear();
    for (const auto& stored_values : stored_values_) {
      for (const int64_t value : stored_values) {
        values.push_back(intercept + slope * static_cast<double>(value));
      }
    }
    sample_.must_be_noted = is_inverse_;
  }

  /// The only file, and contradictions that any kind of file can have.
  void finish_file(const DicomItem& d, const char* kind) {
    sample_.main = "v.dcm";
    sample_.files["v.dcm"] = file_of(d);
    sample_.text = kind;
    for (const int more : {1, -1}) {
      add_damage("v.dcm", d, [&](DicomItem& i) {
        i[0x00280008] = test::dicom_text("IS", std::to_string(slices() + more));
      });
    }
    add_damage("v.dcm", d, [&](DicomItem& i) {
      i[0x00280010] = test::dicom_u16(static_cast<uint16_t>(rows() + 1));
    });
    add_damage("v.dcm", d, [&](DicomItem& i) { i.erase(0x7fe00010); });
  }

  Random& random_;
  Pixels pixels_;
  Sample sample_;
  DicomSyntax syntax_;
  Vec3d row_{1, 0, 0}, column_{0, 1, 0}, spacing_{1, 1, 1};
  std::vector<std::vector<int64_t>> stored_values_;  ///< by slice
  std::vector<double> slopes_;                       ///< by slice
  double intercept_ = 0;
  bool differ_ = false;  ///< slices have different slopes
  bool has_rescaling_ = false;
  bool is_inverse_ = false;
};

}  // namespace

Sample make_dicom(Random& random) {
  return Maker(random).make();
}

}  // namespace isosplat::conformance
