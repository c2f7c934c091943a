#pragma once

#include <cstdint>
#include <string_view>

namespace isosplat {

/// What is an error unless the user allows it by name. Where it is allowed and happens, the volume
/// has a note that says so.
enum class Allowance : uint8_t { gaps, truncated, surplus, unplaced };

struct AllowanceFlag {
  Allowance allowance;
  const char* flag;  ///< on the command line
  const char* help;
};

/// Every allowance, in the order of the enumeration: the command line and messages take them from
/// here.
inline constexpr AllowanceFlag kAllowances[] = {
    {Allowance::gaps, "--allow-gaps",
     "Read a series or list of slices though some are missing, unreadable or unevenly spaced"},
    {Allowance::truncated, "--allow-truncated",
     "Read a file that ends before its last voxel; what is missing has no value"},
    {Allowance::surplus, "--allow-surplus",
     "Read a file that holds more voxels than its header says; what is too much is left out"},
    {Allowance::unplaced, "--allow-unplaced",
     "Stack DICOM slices that do not say where they are in the order of their instance numbers"},
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

}  // namespace isosplat
