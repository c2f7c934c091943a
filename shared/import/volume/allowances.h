#pragma once

#include <cstdint>
#include <string_view>

namespace isosplat::import {

/// A fault of a volume file that is an error unless the user allows it by name. If it is allowed
/// and occurs, the volume has a note about it.
enum class Allowance : uint8_t { gaps, truncated, surplus, unplaced, frames };

struct AllowanceFlag {
  Allowance allowance;
  const char* flag;  ///< the command line option
  const char* help;
};

/// Every allowance, in the order of the enumeration. The command line and the error messages use
/// this list.
inline constexpr AllowanceFlag kAllowances[] = {
    {Allowance::gaps, "--allow-gaps",
     "Read a series or list of slices even if slices are missing, unreadable or unevenly spaced"},
    {Allowance::truncated, "--allow-truncated",
     "Read a file that ends before its last voxel; the missing voxels have no value"},
    {Allowance::surplus, "--allow-surplus",
     "Read a file that has more voxels than its header says; ignore the extra voxels"},
    {Allowance::unplaced, "--allow-unplaced",
     "Stack DICOM slices without positions in the order of their instance numbers"},
    {Allowance::frames, "--allow-frames",
     "Read the times or channels of a TIFF file as slices if it has one slice of each"},
};

/// "--allow-gaps", …
constexpr std::string_view flag_of(Allowance allowance) {
  return kAllowances[static_cast<size_t>(allowance)].flag;
}

/// A set of allowances.
class Allowances {
 public:
  constexpr bool has(Allowance allowance) const { return (bits_ & bit(allowance)) != 0; }
  constexpr void add(Allowance allowance) { bits_ |= bit(allowance); }

 private:
  static constexpr uint32_t bit(Allowance allowance) {
    return uint32_t{1} << static_cast<uint32_t>(allowance);
  }
  uint32_t bits_ = 0;
};

}  // namespace isosplat::import
