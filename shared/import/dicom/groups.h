#pragma once

#include <vector>

#include "shared/import/dicom/elements.h"

namespace isosplat::import::dicom {

/// The functional groups of a file's frames (PS3.3, C.7.6.16): sequences for single frames, or for
/// all frames. Refers to the data set.
class FrameGroups {
 public:
  explicit FrameGroups(const Item& data);

  const Item& data() const { return data_; }

  /// Number of frames that the file describes; 0: none.
  size_t described() const { return per_frame_ ? per_frame_->size() : 0; }

  /// The items of a group's sequence: the frame's own, or those shared by all frames; empty if
  /// there are none.
  const std::vector<Item>& items(size_t frame, Tag sequence) const;

  /// The first of these items; null if there are none.
  const Item* find(size_t frame, Tag sequence) const;

  /// The number of an element of a group, or else of the data set; nothing if it is in neither.
  std::optional<double> number(size_t frame, Tag sequence, Tag tag) const;

 private:
  const Item& data_;
  const Item* shared_ = nullptr;
  const std::vector<Item>* per_frame_ = nullptr;
};

}  // namespace isosplat::import::dicom
