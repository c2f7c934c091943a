#pragma once

#include <complex>
#include <span>
#include <vector>

#include "tests/evidence/ewa/signal.h"

namespace isosplat {

/// The discrete Fourier transform, in place (Cooley and Tukey 1965). Requires a power of two.
void fourier(std::span<std::complex<double>> values);

/// The spectrum of a picture that was drawn at `per_px` × `per_px` positions in each pixel. So it
/// distinguishes frequencies up to ½ per_px cycles per px. A picture with
/// one value for each pixel folds all of them into |f| ≤ ½.
class Spectrum {
 public:
  /// The picture has per_px values for each pixel along each axis; both sides are powers of two.
  /// Its mean is subtracted, and it is faded out towards its edges (Hann's window).
  Spectrum(const Luminance& fine, int per_px);

  /// The alias: a picture with one value per pixel shows waves beyond ½ cycle per px, along x or y,
  /// as alias. Returns their root mean square, divided by that of the waves of `truth` below this
  /// frequency.
  double alias(const Spectrum& truth) const;

  /// The share of the waves of `truth` with `low` to `high` cycles per px that remains in phase:
  /// Re Σ P conj(S) / Σ |S|².
  double contrast(const Spectrum& truth, double low, double high) const;

 private:
  /// Cycles per px of the i-th value of a side.
  double frequency(int i) const;
  template <class F>
  void for_waves(F f) const;

  int side_, per_px_;
  std::vector<std::complex<double>> wave_;
};

/// Combines pictures that were drawn with the pixels' centres moved by (i + ½) / per_px − ½ px to
/// the right, and by (j + ½) / per_px − ½ px down: `pictures[per_px j + i]`.
Luminance interleaved(std::span<const Luminance> pictures, int per_px);

}  // namespace isosplat
