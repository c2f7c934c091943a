#include "shared/import/dicom/values.h"

#include <algorithm>
#include <cmath>

#include "shared/import/dicom/pixels.h"
#include "shared/import/voxels/absent_voxels.h"

namespace isosplat::import::dicom {
namespace {

/// The narrowest integer type for numbers from `low` to `high`; f64 if there is none.
VoxelType type_for(double low, double high) {
  struct Range {
    VoxelType type;
    double low, high;
  };
  constexpr Range kRanges[] = {
      {VoxelType::u8, 0, 255},           {VoxelType::i8, -128, 127},
      {VoxelType::u16, 0, 65535},        {VoxelType::i16, -32768, 32767},
      {VoxelType::u32, 0, 4294967295.0}, {VoxelType::i32, -2147483648.0, 2147483647.0},
  };
  for (const Range& range : kRanges) {
    if (low >= range.low && high <= range.high) return range.type;
  }
  return VoxelType::f64;
}

}  // namespace

Values find_values(const Collection& collection, std::span<const uint32_t> frames,
                   std::optional<int> label) {
  Values values;
  values.label = label;
  const Frame& first = collection.frames[frames[0]];
  double low = 0, high = 0, min_pixel = 0, greatest_pixel = 0;
  bool is_whole = true, is_wide = false, is_float = false, lacks_some = false;
  values.min_slope = values.greatest_slope = first.slope;
  for (const uint32_t index : frames) {
    const Frame& frame = collection.frames[index];
    const Image& image = collection.images[frame.image];
    values.has_one_rescaling = values.has_one_rescaling && frame.slope == first.slope &&
                               frame.intercept == first.intercept;
    values.min_slope = std::min(values.min_slope, frame.slope);
    values.greatest_slope = std::max(values.greatest_slope, frame.slope);
    is_float = is_float || image.is_float;
    lacks_some = lacks_some || image.cut_off;
    is_whole = is_whole && !image.is_float && frame.slope == std::round(frame.slope) &&
               frame.intercept == std::round(frame.intercept);
    is_wide = is_wide || (image.is_float ? image.allocated == 64 : image.stored > 16);
    const auto [smallest, largest] = stored_range(image);
    min_pixel = std::min<double>(min_pixel, smallest);
    greatest_pixel = std::max<double>(greatest_pixel, largest);
    for (const double stored : {smallest, largest}) {
      low = std::min(low, frame.intercept + frame.slope * stored);
      high = std::max(high, frame.intercept + frame.slope * stored);
    }
  }
  if (label) {
    values.type = VoxelType::u8;
  } else if (is_whole) {
    values.type = type_for(low, high);
  } else if (values.has_one_rescaling && !is_float && first.slope != 0) {
    values.type = type_for(min_pixel, greatest_pixel);
    values.slope = first.slope;
    values.intercept = first.intercept;
  } else {
    values.type = is_wide ? VoxelType::f64 : VoxelType::f32;
  }
  if (lacks_some) values.type = type_with_absent(values.type);
  return values;
}

}  // namespace isosplat::import::dicom
