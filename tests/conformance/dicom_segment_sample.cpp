#include <algorithm>
#include <numeric>

#include "tests/conformance/sample.h"
#include "tests/native/dicom_files.h"

// Segmentations, written from PS3.3, A.51 and C.8.20: frames of one bit, fractions, and label maps,
// in any order, without those that are empty.
namespace isosplat::conformance {
namespace {

using test::dicom_sequence;
using test::dicom_text;
using test::dicom_u16;
using test::DicomItem;

enum class Type { binary, fractional, labels };

class Maker {
 public:
  explicit Maker(Random& random) : random_(random) {}

  Sample make() {
    type_ = random_.one_of({Type::binary, Type::binary, Type::fractional, Type::labels});
    choose_geometry();
    choose_voxels();
    write();
    sample_.text = fmt::format("{}, {} segments, {} of {} slices have frames",
                               type_ == Type::binary       ? "BINARY"
                               : type_ == Type::fractional ? "FRACTIONAL"
                                                           : "LABELMAP",
                               segments_, slices_with_frames_, slices());
    return std::move(sample_);
  }

 private:
  int columns() const { return sample_.truth.sizes[0]; }
  int rows() const { return sample_.truth.sizes[1]; }
  int slices() const { return sample_.truth.sizes[2]; }

  void choose_geometry() {
    Truth& truth = sample_.truth;
    truth.sizes = {random_.between(3, 9), random_.between(3, 9), random_.between(2, 7)};
    truth.steps = choose_steps(random_);
    truth.origin = choose_place(random_);
    spacing_ = {length(truth.steps[0]), length(truth.steps[1]), length(truth.steps[2])};
  }

  /// Voxels of each segment. The first and the last slice are not empty: otherwise the volume would
  /// be shorter.
  void choose_voxels() {
    segments_ = random_.between(1, 3);
    chosen_ = random_.between(0, segments_ - 1);
    states_distance_ = random_.chance(70);
    const size_t area = static_cast<size_t>(columns() * rows());
    for (int s = 0; s < segments_; ++s) {
      std::vector<std::vector<int>> volume;
      for (int z = 0; z < slices(); ++z) {
        const bool is_end = z == 0 || z + 1 == slices();
        const bool is_empty = is_end ? s != 0 : random_.chance(40) && states_distance_;
        std::vector<int> slice(area, 0);
        for (int& voxel : slice) {
          if (!is_empty && random_.chance(50)) voxel = value(s);
        }
        if (!is_empty) slice[0] = value(s);
        volume.push_back(std::move(slice));
      }
      voxels_.push_back(std::move(volume));
    }
  }

  int value(int segment) const {
    return type_ == Type::binary   ? 1
           : type_ == Type::labels ? segment + 1
                                   : random_.between(1, 250);
  }

  /// A frame of a segment; of a label map, of all segments.
  std::vector<int> frame(int segment, int z) const {
    std::vector<int> pixels = voxels_[static_cast<size_t>(segment)][static_cast<size_t>(z)];
    if (type_ != Type::labels) return pixels;
    for (int s = 1; s < segments_; ++s) {
      const auto& more = voxels_[static_cast<size_t>(s)][static_cast<size_t>(z)];
      for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = std::max(pixels[i], more[i]);
    }
    return pixels;
  }

  void write() {
    struct Place {
      int segment, z;
    };
    std::vector<Place> places;
    const bool keeps_empty = random_.chance(30);
    const int frames_of = type_ == Type::labels ? 1 : segments_;
    std::set<int> seen, all;
    for (int s = 0; s < frames_of; ++s) {
      for (int z = 0; z < slices(); ++z) {
        const auto pixels = frame(s, z);
        const bool is_empty = std::count(pixels.begin(), pixels.end(), 0) ==
                              static_cast<std::ptrdiff_t>(pixels.size());
        if (is_empty && !keeps_empty) continue;
        places.push_back({s, z});
        all.insert(z);
        if (s == (type_ == Type::labels ? 0 : chosen_)) seen.insert(z);
      }
    }
    slices_with_frames_ = static_cast<int>(seen.size());
    for (size_t i = places.size(); i-- > 1;) {
      std::swap(places[i], places[static_cast<size_t>(random_.between(0, static_cast<int>(i)))]);
    }
    choose_segment(seen.empty());

    DicomItem d = header(places.size());
    std::vector<DicomItem> groups;
    std::vector<uint8_t> pixels;
    for (const auto& [segment, z] : places) {
      const Vec3d p = sample_.truth.origin + sample_.truth.steps[2] * z;
      DicomItem group{{0x00209113, dicom_sequence({{{0x00200032, numbers({p.x, p.y, p.z})}}})}};
      if (type_ != Type::labels) {
        group[0x0062000a] = dicom_sequence({{{0x0062000b, dicom_u16(number_of(segment))}}});
      }
      groups.push_back(std::move(group));
      for (const int voxel : frame(segment, z)) pixels.push_back(static_cast<uint8_t>(voxel));
    }
    d[0x52009230] = dicom_sequence(groups);
    if (type_ == Type::binary) {
      d[0x7fe00010] = test::dicom_bits(pixels);
    } else {
      if (pixels.size() % 2) pixels.push_back(0);
      d[0x7fe00010] = test::dicom_numbers("OB", pixels);
    }
    sample_.main = "seg.dcm";
    sample_.files["seg.dcm"] = file_of(d);
    sample_.must_be_noted = (segments_ > 1 && type_ != Type::labels) ||
                            slices_with_frames_ < slices() || type_ == Type::fractional ||
                            !sample_.options.segment.empty();
    add_damages(d, all.size() > 2);
  }

  static uint16_t number_of(int segment) { return static_cast<uint16_t>(segment + 1); }
  static std::string label_of(int segment) { return fmt::format("Part {}", segment + 1); }

  /// The values to expect, and the option that chooses them.
  void choose_segment(bool is_without_frames) {
    if (is_without_frames) chosen_ = 0;  // the first segment has frames
    const bool is_mask = type_ == Type::labels && random_.chance(40);
    if (is_mask || (segments_ > 1 && type_ != Type::labels)) {
      sample_.options.segment =
          random_.chance(50) ? std::to_string(number_of(chosen_)) : label_of(chosen_);
    }
    for (int z = 0; z < slices(); ++z) {
      for (const int voxel : frame(type_ == Type::labels ? 0 : chosen_, z)) {
        sample_.truth.values.push_back(is_mask ? voxel == number_of(chosen_) : voxel);
      }
    }
  }

  DicomItem header(size_t frames) const {
    const auto& steps = sample_.truth.steps;
    const Vec3d row = steps[0] * (1 / spacing_.x), column = steps[1] * (1 / spacing_.y);
    const bool is_bit = type_ == Type::binary;
    DicomItem d;
    d[0x00080016] = dicom_text("UI", type_ == Type::labels ? "1.2.840.10008.5.1.4.1.1.66.7"
                                                           : "1.2.840.10008.5.1.4.1.1.66.4");
    d[0x00080018] = dicom_text("UI", "1.2.3.4.1");
    d[0x00080060] = dicom_text("CS", "SEG");
    d[0x0020000e] = dicom_text("UI", "1.2.3.4");
    d[0x00280002] = dicom_u16(1);
    d[0x00280004] =
        dicom_text("CS", type_ == Type::labels && columns() % 2 ? "PALETTE COLOR" : "MONOCHROME2");
    d[0x00280008] = dicom_text("IS", std::to_string(frames));
    d[0x00280010] = dicom_u16(static_cast<uint16_t>(rows()));
    d[0x00280011] = dicom_u16(static_cast<uint16_t>(columns()));
    d[0x00280100] = d[0x00280101] = dicom_u16(is_bit ? 1 : 8);
    d[0x00280102] = dicom_u16(is_bit ? 0 : 7);
    d[0x00280103] = dicom_u16(0);
    if (type_ == Type::labels) d[0x00280120] = dicom_u16(0);
    d[0x00620001] = dicom_text("CS", is_bit                      ? "BINARY"
                                     : type_ == Type::fractional ? "FRACTIONAL"
                                                                 : "LABELMAP");
    std::vector<DicomItem> segments;
    for (int s = 0; s < segments_; ++s) {
      segments.push_back(
          {{0x00620004, dicom_u16(number_of(s))}, {0x00620005, dicom_text("LO", label_of(s))}});
    }
    d[0x00620002] = dicom_sequence(segments);
    if (type_ == Type::fractional) d[0x0062000e] = dicom_u16(250);
    DicomItem measures{{0x00280030, numbers({spacing_.y, spacing_.x})}};
    if (states_distance_) measures[0x00180088] = numbers({spacing_.z});
    const auto orientation = numbers({row.x, row.y, row.z, column.x, column.y, column.z});
    d[0x52009229] = dicom_sequence({{{0x00209116, dicom_sequence({{{0x00200037, orientation}}})},
                                     {0x00289110, dicom_sequence({measures})}}});
    return d;
  }

  static test::DicomValue numbers(const std::vector<double>& values) {
    return dicom_text("DS", test::dicom_decimals(values));
  }

  std::string file_of(const DicomItem& d) const {
    const auto syntaxes = {test::DicomSyntax{}, test::implicit_little(), test::explicit_big(),
                           test::deflated_little()};
    return test::DicomWriter(*(syntaxes.begin() + (columns() + rows()) % 4)).file(d);
  }

  void add_damages(const DicomItem& d, bool is_line) {
    const auto damage = [&](const std::function<void(DicomItem&)>& change) {
      DicomItem changed = d;
      change(changed);
      sample_.damages.push_back(
          [bytes = file_of(changed)](auto& files) { files["seg.dcm"] = bytes; });
    };
    damage([](DicomItem& i) { i[0x52009230].items.pop_back(); });
    damage([](DicomItem& i) { i[0x52009230].items[0].erase(0x00209113); });
    damage([](DicomItem& i) { i.erase(0x7fe00010); });
    damage([](DicomItem& i) { i.erase(0x00280011); });
    damage([&](DicomItem& i) { i[0x00280010] = dicom_u16(static_cast<uint16_t>(3 * rows())); });
    if (!is_line) return;  // two slices are in line wherever they are
    damage([&](DicomItem& i) {
      const Vec3d p =
          sample_.truth.origin + sample_.truth.steps[2] * 0.4 + sample_.truth.steps[0] * 3;
      i[0x52009230].items[0][0x00209113] =
          dicom_sequence({{{0x00200032, numbers({p.x, p.y, p.z})}}});
    });
  }

  Random& random_;
  Sample sample_;
  Type type_ = Type::binary;
  Vec3d spacing_{1, 1, 1};
  int segments_ = 1, chosen_ = 0, slices_with_frames_ = 0;
  bool states_distance_ = true;
  std::vector<std::vector<std::vector<int>>> voxels_;  ///< by segment and slice
};

}  // namespace

Sample make_dicom_segments(Random& random) {
  return Maker(random).make();
}

}  // namespace isosplat::conformance
