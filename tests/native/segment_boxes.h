#pragma once

#include "tests/native/dicom_segmentation.h"

namespace isosplat::test {

/// A segment that fills a box of voxels, both ends included.
struct SegmentBox {
  int number;
  std::string label;
  Index3 low, high;
  std::string meaning = {}, modifier = {};  ///< of its codes
  std::vector<uint16_t> cie_lab = {};

  bool has(int x, int y, int z) const {
    return x >= low.x && x <= high.x && y >= low.y && y <= high.y && z >= low.z && z <= high.z;
  }
  uint64_t voxels() const {
    return static_cast<uint64_t>(high.x - low.x + 1) * static_cast<uint64_t>(high.y - low.y + 1) *
           static_cast<uint64_t>(high.z - low.z + 1);
  }
};

/// A DICOM segmentation of boxes, with slices 2 mm apart from (0, 0, 0) on, and pixels of 1 × 1.5
/// mm. A segment has no frames for slices in which it has no pixels. In label maps, later boxes
/// replace earlier ones. Fractional values are 120 of 200 inside of a box, and 80 in a margin of
/// one pixel around it in its slices.
struct SegmentBoxes {
  std::vector<SegmentBox> boxes;
  SegmentType type = SegmentType::binary;
  Index3 size{19, 17, 12};  // rows and frames do not fill whole bytes
  int background = 0;       ///< of label maps

  std::vector<uint8_t> frame(int z, const SegmentBox& box) const {
    std::vector<uint8_t> pixels;
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        const bool is_inside = box.has(x, y, z);
        const bool is_near = box.has(std::clamp(x, box.low.x, box.high.x),
                                     std::clamp(y, box.low.y, box.high.y), z) &&
                             std::abs(x - std::clamp(x, box.low.x, box.high.x)) <= 1 &&
                             std::abs(y - std::clamp(y, box.low.y, box.high.y)) <= 1;
        const int fraction = is_inside ? 120 : is_near ? 80 : 0;
        pixels.push_back(
            static_cast<uint8_t>(type == SegmentType::fractional ? fraction : is_inside));
      }
    }
    return pixels;
  }

  std::vector<uint8_t> labels(int z) const {
    std::vector<uint8_t> pixels(static_cast<size_t>(size.x * size.y),
                                static_cast<uint8_t>(background));
    for (const SegmentBox& box : boxes) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          if (box.has(x, y, z)) {
            pixels[static_cast<size_t>(y * size.x + x)] = static_cast<uint8_t>(box.number);
          }
        }
      }
    }
    return pixels;
  }

  static DicomItem description(const SegmentBox& box) {
    DicomItem item = segment_description(box.number, box.label);
    if (!box.meaning.empty()) {
      DicomItem code{{0x00080100, dicom_text("SH", "64033007")},
                     {0x00080104, dicom_text("LO", box.meaning)}};
      if (!box.modifier.empty()) {
        code[0x00620011] = dicom_sequence({{{0x00080104, dicom_text("LO", box.modifier)}}});
      }
      item[0x0062000f] = dicom_sequence({code});
    }
    if (!box.cie_lab.empty()) item[0x0062000d] = dicom_numbers("US", box.cie_lab);
    return item;
  }

  DicomItem data() const {
    BallSeries series;
    series.size = size;
    std::vector<DicomItem> descriptions;
    for (const SegmentBox& box : boxes) descriptions.push_back(description(box));
    Segmentation made(
        series, type, std::move(descriptions),
        {{0x00280030, dicom_text("DS", "1.5\\1")}, {0x00180088, dicom_text("DS", "2")}});
    const auto add = [&](int z, const std::vector<uint8_t>& pixels, int segment) {
      made.add(dicom_text("DS", dicom_decimals({0, 0, 2.0 * z})), pixels, segment);
    };
    const bool are_labels = type == SegmentType::labels;
    for (int z = 0; z < size.z && are_labels; ++z) add(z, labels(z), 0);
    for (const SegmentBox& box : boxes) {
      for (int z = box.low.z; z <= box.high.z && !are_labels; ++z)
        add(z, frame(z, box), box.number);
    }
    DicomItem data = made.data();
    if (are_labels) data[0x00280120] = dicom_u16(static_cast<uint16_t>(background));
    return data;
  }

  std::string file(const DicomSyntax& syntax = {}) const {
    return DicomWriter(syntax).file(data());
  }
};

/// Five boxes: 2 touches 1, 3 is within 1, 4 overlaps 2 and 3, 9 lies apart.
inline SegmentBoxes five_boxes() {
  SegmentBoxes file;
  file.boxes = {{1, "liver", {1, 1, 1}, {8, 9, 9}},
                {2, "spleen", {9, 1, 2}, {14, 6, 8}},
                {3, "tumour", {3, 3, 3}, {7, 7, 7}},
                {4, "margin", {5, 2, 2}, {11, 8, 6}},
                {9, "node", {16, 12, 5}, {18, 16, 11}}};
  return file;
}

}  // namespace isosplat::test
