#pragma once

#include "shared/base/status.h"
#include "shared/render/image_target.h"

namespace isosplat {

/// By how much a picture is moved, in pixels.
struct ImageOffset {
  double right = 0, up = 0;
};

/// The sum of pictures of one still view, each moved by another part of a pixel: their mean is the
/// picture with smooth edges (P. Haeberli, K. Akeley, "The accumulation buffer", SIGGRAPH 1990).
/// Sums are linear colours in 16-bit floats: needs RendererLimits::float_targets.
class Accumulation {
 public:
  /// Pictures in a mean; more would change no pixel by much.
  static constexpr int kPictures = 8;

  /// Picture n's offset, within ± ½ pixel; picture 0 is not moved. Any first few are spread evenly
  /// (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018: R₂).
  static ImageOffset offset(int n);

  /// Makes room for sums of this size, without pictures. Errors: gl_error.
  Result<void> begin(int width, int height);
  void picture_added() { ++pictures_; }
  /// Forgets the pictures, keeps the room.
  void restart() { pictures_ = 0; }

  int pictures() const { return pictures_; }
  const ImageTarget& sums() const { return sums_; }

  void release();
  void abandon();

 private:
  ImageTarget sums_{GL_RGBA16F, "to smooth an image"};
  int pictures_ = 0;
};

}  // namespace isosplat
