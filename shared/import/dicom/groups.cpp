#include "shared/import/dicom/groups.h"

namespace isosplat::import::dicom {

FrameGroups::FrameGroups(const Item& data) : data_(data), shared_(data.first_item(kSharedGroups)) {
  if (const Element* groups = data.find(kPerFrameGroups)) per_frame_ = &groups->items;
}

const std::vector<Item>& FrameGroups::items(size_t frame, Tag sequence) const {
  static const std::vector<Item> kNone;
  const Element* found = nullptr;
  if (frame < described()) found = (*per_frame_)[frame].find(sequence);
  if ((!found || found->items.empty()) && shared_) found = shared_->find(sequence);
  return found ? found->items : kNone;
}

const Item* FrameGroups::find(size_t frame, Tag sequence) const {
  const std::vector<Item>& all = items(frame, sequence);
  return all.empty() ? nullptr : &all.front();
}

std::optional<double> FrameGroups::number(size_t frame, Tag sequence, Tag tag) const {
  if (const Item* item = find(frame, sequence)) {
    if (const auto number = item->number(tag)) return number;
  }
  return data_.number(tag);
}

}  // namespace isosplat::import::dicom
