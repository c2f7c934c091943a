#pragma once

#include <cstdint>

#include "shared/core/codec/lattice.h"
#include "shared/core/codec/simd_widest.h"

namespace isosplat {

/// Computes the residuals of a plane's points for the encoder. The encoder knows all values
/// beforehand, so it can predict as many points at once as a vector has lanes: a window of kLanes
/// adjacent positions of a row. Most points have all their neighbours, and so one class: all points
/// of a window are predicted with that class, and those of other classes again one by one. Scratch
/// memory: about 60 KB.
class PlaneResiduals {
 public:
  /// put() may overwrite this many entries after those that it writes.
  static constexpr int kSlack = 16;

  /// taps: the weights of each class, in the order of lattice.h.
  void set_predictor(const int32_t (*taps)[kTaps], bool wide) { predictor_.set(taps, wide); }

  /// Starts a new plane, without rows.
  void clear() { windows_ = others_ = 0; }

  /// Adds row y; rows must come in coding order. `n` and `row` must stay valid until put(); `row`
  /// has the values of all its points.
  void add_row(const PointPlane& current, const PointPlane& previous, int32_t y,
               const Neighbours& n, const Row& row);

  /// Writes the residual_entry() of each point of the added rows, and returns the end of the
  /// entries. Then `energies` has those of this plane; the contexts use those of the planes before.
  uint32_t* put(Energies& energies, uint32_t* to);

 private:
#if ISOSPLAT_CODEC_SIMD
  static constexpr int32_t kLanes = sizeof(simd::Widest) / sizeof(int16_t);
#else
  static constexpr int32_t kLanes = 16;
#endif
  /// The class of points that have all their neighbours.
  static constexpr uint32_t kWhole = kClasses - 1;

  struct Window {
    uint8_t x, y;
    uint16_t points;   ///< bit i: position x + i has a point
    uint16_t others;   ///< the points of another class than kWhole
    uint16_t exposed;  ///< the positions of group kExposed, also where there is no point
  };
  struct Other {
    uint8_t x, y, point_class;
    uint16_t lane;  ///< index into prediction_: kLanes · window + lane of the window
  };
  static constexpr int32_t kMaxWindows = kLatticeAcross * (kBlockCells / kLanes + 1);
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
  // By kLanes · window + lane:
  int16_t key_[kMaxWindows * kLanes];
  int16_t prediction_[kMaxWindows * kLanes] = {};  ///< of the points in other_
  int32_t windows_ = 0, others_ = 0;
};

}  // namespace isosplat
