#include "native/remote/recent_ranges.h"

#include <algorithm>

namespace isosplat::remote {

bool RecentRanges::read(uint64_t offset, std::span<std::byte> out) const {
  std::shared_ptr<const Range> range;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = std::find_if(ranges_.rbegin(), ranges_.rend(), [&](const auto& each) {
      return offset >= each->offset && offset - each->offset <= each->bytes.size() &&
             out.size() <= each->bytes.size() - (offset - each->offset);
    });
    if (found == ranges_.rend()) return false;
    range = *found;
  }
  std::copy_n(range->bytes.begin() + static_cast<ptrdiff_t>(offset - range->offset), out.size(),
              out.begin());
  return true;
}

void RecentRanges::add(uint64_t offset, std::vector<std::byte> bytes) {
  if (bytes.size() > max_bytes_ / 4) return;
  auto range = std::make_shared<const Range>(Range{offset, std::move(bytes)});
  const std::scoped_lock lock(mutex_);
  bytes_ += range->bytes.size();
  ranges_.push_back(std::move(range));
  while (bytes_ > max_bytes_) {
    bytes_ -= ranges_.front()->bytes.size();
    ranges_.pop_front();
  }
}

}  // namespace isosplat::remote
