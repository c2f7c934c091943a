#include "shared/import/dicom/copies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <tuple>

namespace isosplat::import::dicom {
namespace {

bool is_copy(const Frame& a, const Frame& b) {
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return a.position == b.position && a.slope == b.slope && a.intercept == b.intercept &&
         std::equal(a.keys.begin(), a.keys.end(), b.keys.begin(), same);
}

}  // namespace

Result<std::vector<uint32_t>> without_copies(const OrderInput& in,
                                             const std::vector<uint32_t>& frames) {
  std::map<std::tuple<std::string_view, uint32_t, uint32_t>, uint32_t> frame_by_uid;
  std::vector<uint32_t> kept;
  for (const uint32_t frame : frames) {
    const std::string_view uid = in.image_of(frame).instance_uid;
    if (uid.empty()) {
      kept.push_back(frame);
      continue;
    }
    const auto [found, is_new] =
        frame_by_uid.try_emplace({uid, in.frame_of(frame).index, in.frame_of(frame).tile}, frame);
    if (is_new) {
      kept.push_back(frame);
    } else if (!is_copy(in.frame_of(frame), in.frame_of(found->second))) {
      return in.malformed(
          fmt::format("expected different instance numbers (SOP Instance UID) for "
                      "different slices, found {} in {} and {}: export the series "
                      "again",
                      uid, in.image_of(frame).file, in.image_of(found->second).file));
    }
  }
  if (const size_t copies = frames.size() - kept.size(); copies > 0) {
    in.notes.push_back(fmt::format("{} slice{} duplicated: the copies are ignored", copies,
                                   copies > 1 ? "s are" : " is"));
  }
  return kept;
}

}  // namespace isosplat::import::dicom
