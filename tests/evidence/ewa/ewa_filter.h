#pragma once

#include <span>
#include <vector>

#include "tests/evidence/ewa/splat.h"

namespace isosplat {

/// Parameters of the EWA resampling filter.
struct EwaSettings {
  double low_pass = 1;  ///< variance of the low-pass filter, px²
  double cutoff = 4;    ///< filters end there, in standard deviations
  /// The same for the discs that decide about visibility. Smaller discs leave holes in engine close
  /// up, and larger ones reach farther beyond outlines.
  double visible_cutoff = 2;
  double depth_threshold = 1;  ///< world units: surfels this far behind the nearest are blended
};

/// The result of the filter, rows from the top.
struct EwaPicture {
  int width = 0, height = 0;
  std::vector<Vec3f> colour;   ///< linear: sum of weights times colours / sum of weights
  std::vector<double> weight;  ///< sum of weights: nearly 1 inside of evenly sampled surfaces

  /// Share of the pixel that is covered (at most 1), for outlines: the greater of two sums of
  /// weights. One sum is over all surfels that face the eye, including hidden ones, the other over
  /// all that face away. Each is 1 inside of a closed surface, and falls like the low-pass filter
  /// at its outline.
  std::vector<double> coverage;

  size_t at(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
};

/// Draws surfels with the EWA resampling filter of Zwicker et al. 2001: the colour of a pixel is
/// Σ w c / Σ w over the surfels of the visible surface there, with the weights of ScreenSplat.
///
/// Two passes replace the paper's A-buffer. The first finds the nearest depth in each pixel, from
/// discs in the tangent planes, whose radius is that of the reconstruction kernels alone; a disc
/// that covers no pixel's centre counts in the pixel of its own centre. The second adds up the
/// surfels that lie within a threshold behind this depth. The threshold is enlarged by the depth
/// that the surfel's tangent plane spans in its filter, so that a plane seen from the side is
/// filtered completely.
EwaPicture draw_ewa(std::span<const Surfel> surfels, const ImagePlane& image,
                    const EwaSettings& settings = {});

}  // namespace isosplat
