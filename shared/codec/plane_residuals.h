#pragma once

#include <cstdint>

#include "shared/codec/lattice.h"
#include "shared/codec/simd_widest.h"

namespace isosplat {

/// Finds the residuals of a plane's points for the encoder, which knows all values beforehand: by
/// windows of places of a row, as many as a vector holds. Most points have all their neighbours: a
/// window is predicted as if all of its points had, and the others are predicted one by one.
/// Keeps scratch memory: about 60 KB.
class PlaneResiduals {
 public:
  /// put() may overwrite so many entries beyond those it writes.
  static constexpr int kBeyond = 16;

  /// taps: the weights of each class, in the order of lattice.h.
  void set_predictor(const int32_t (*taps)[kTaps], bool wide) { predictor_.set(taps, wide); }

  /// Forgets the plane before.
  void clear() { windows_ = others_ = 0; }

  /// Adds row y, in coding order. `row` is the row itself, with all of its points set.
  void add_row(const PointPlane& current, const PointPlane& previous, int32_t y,
               const Neighbours& n, const Row& row);

  /// Writes the residual_entry() of each point of the rows added, and returns where the next one
  /// goes. Sets the points' energies, once all contexts are found.
  uint32_t* put(Energies& energies, uint32_t* to);

 private:
#if ISOSPLAT_CODEC_SIMD
  static constexpr int32_t kPlaces = sizeof(simd::Widest) / sizeof(int16_t);
#else
  static constexpr int32_t kPlaces = 16;
#endif
  /// The class of points that have all their neighbours.
  static constexpr uint32_t kWhole = kClasses - 1;

  struct Window {
    uint8_t x, y;
    uint16_t points;   ///< a bit for each place from x on
    uint16_t others;   ///< those points that have another class than kWhole
    uint16_t exposed;  ///< places whose points are, or would be, of group kExposed
  };
  struct Other {
    uint8_t x, y, point_class;
    uint16_t place;  ///< kPlaces · its window + the place therein
  };
  static constexpr int32_t kMaxWindows = kLatticeAcross * (kBlockCells / kPlaces + 1);
  static constexpr int32_t kMaxPoints = kLatticeAcross * kLatticeAcross;

  void add_word(const PointPlane& current, const PointPlane& previous, int32_t y, int word);
  void find_keys(const Energies& energies);
  void predict_others();

  Predictor predictor_;
  struct {
    Neighbours neighbours;
    const int16_t* values;  ///< from point 0 on
  } rows_[kLatticeAcross];
  Window window_[kMaxWindows + 1];
  Other other_[kMaxPoints + 3];
  // By place:
  int16_t key_[kMaxWindows * kPlaces];
  int16_t prediction_[kMaxWindows * kPlaces] = {};  ///< of the others
  int32_t windows_ = 0, others_ = 0;
};

}  // namespace isosplat
