#pragma once

#include "tests/native/dicom_files.h"

namespace isosplat::test {

enum class SegmentType { binary, fractional, labels };

/// The data of a DICOM segmentation, whose frames are added one after the other. Fractions are of
/// 200.
class Segmentation {
 public:
  /// `segments`: their descriptions, with at least a number and a label. `measures`: the Pixel
  /// Measures of all frames. The size and the orientation are those of `series`.
  Segmentation(const BallSeries& series, SegmentType type, std::vector<DicomItem> segments,
               DicomItem measures)
      : type_(type), data_(series.common()) {
    data_[0x00080016] =
        dicom_text("UI", type == SegmentType::labels ? "1.2.840.10008.5.1.4.1.1.66.7"
                                                     : "1.2.840.10008.5.1.4.1.1.66.4");
    data_[0x00080018] = dicom_text("UI", "1.2.3.4.77");
    data_[0x00080060] = dicom_text("CS", "SEG");
    const int bits = type == SegmentType::binary ? 1 : 8;
    data_[0x00280100] = data_[0x00280101] = dicom_u16(static_cast<uint16_t>(bits));
    data_[0x00280102] = dicom_u16(static_cast<uint16_t>(bits - 1));
    data_[0x00620001] = dicom_text("CS", type == SegmentType::binary       ? "BINARY"
                                         : type == SegmentType::fractional ? "FRACTIONAL"
                                                                           : "LABELMAP");
    data_[0x00620002] = dicom_sequence(std::move(segments));
    if (type == SegmentType::fractional) data_[0x0062000e] = dicom_u16(200);
    data_[0x52009229] =
        dicom_sequence({{{0x00209116, dicom_sequence({{{0x00200037, series.orientation_value()}}})},
                         {0x00289110, dicom_sequence({std::move(measures)})}}});
  }

  /// `position`: of the frame's first pixel. `segment`: not stated in label maps.
  void add(DicomValue position, const std::vector<uint8_t>& pixels, int segment) {
    pixels_.insert(pixels_.end(), pixels.begin(), pixels.end());
    DicomItem group{{0x00209113, dicom_sequence({{{0x00200032, std::move(position)}}})}};
    if (type_ != SegmentType::labels) {
      group[0x0062000a] =
          dicom_sequence({{{0x0062000b, dicom_u16(static_cast<uint16_t>(segment))}}});
    }
    groups_.push_back(std::move(group));
  }

  DicomItem data() const {
    DicomItem data = data_;
    data[0x00280008] = dicom_text("IS", std::to_string(groups_.size()));
    data[0x52009230] = dicom_sequence(groups_);
    std::vector<uint8_t> pixels = pixels_;
    if (type_ != SegmentType::binary && pixels.size() % 2) pixels.push_back(0);
    data[0x7fe00010] =
        type_ == SegmentType::binary ? dicom_bits(pixels) : dicom_numbers("OB", pixels);
    return data;
  }

 private:
  SegmentType type_;
  DicomItem data_;
  std::vector<DicomItem> groups_;
  std::vector<uint8_t> pixels_;
};

inline DicomItem segment_description(int number, const std::string& label) {
  return {{0x00620004, dicom_u16(static_cast<uint16_t>(number))},
          {0x00620005, dicom_text("LO", label)}};
}

}  // namespace isosplat::test
