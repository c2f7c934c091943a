#pragma once

#include "shared/core/base/status.h"
#include "shared/render/frame/image_tile.h"
#include "shared/render/gl/image_target.h"

namespace isosplat::render {

/// The sum of pictures of one camera view, each moved by a different fraction of a pixel. Their
/// mean has smooth edges (P. Haeberli, K. Akeley, "The accumulation buffer", SIGGRAPH 1990). Sums
/// are linear colours in 16-bit floats, which needs RendererLimits::float_targets.
class Accumulation {
 public:
  /// Pictures in a mean. More pictures hardly change it.
  static constexpr int kPictures = 8;

  /// Offset of picture n, within ± ½ pixel; picture 0 is not moved. The first n offsets are evenly
  /// distributed, for any n (M. Roberts, "The unreasonable effectiveness of quasirandom sequences",
  /// 2018: R₂).
  static ImageOffset offset(int n);

  /// Allocates and clears the sums for this size. Errors: gl_error.
  Result<void> begin(int width, int height);
  void picture_added() { ++pictures_; }
  /// Starts a new mean, and keeps the allocation.
  void restart() { pictures_ = 0; }

  int pictures() const { return pictures_; }
  const ImageTarget& sums() const { return sums_; }

  void release();
  void abandon();

 private:
  ImageTarget sums_{GL_RGBA16F, "to smooth an image"};
  int pictures_ = 0;
};

}  // namespace isosplat::render
