#include "shared/import/axes/array_axes.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>

#include "shared/import/geometry/conventions.h"
#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

/// The words of a name: letters and digits between other characters.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      words.back() += c;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

char letter_of_word(std::string_view word, bool has_width) {
  struct Known {
    std::string_view word;
    char letter;
  };
  static constexpr Known kWords[] = {
      {"lon", 'x'},       {"longitude", 'x'},  {"easting", 'x'},    {"column", 'x'},
      {"columns", 'x'},   {"col", 'x'},        {"cols", 'x'},       {"width", 'x'},
      {"lat", 'y'},       {"latitude", 'y'},   {"northing", 'y'},   {"row", 'y'},
      {"rows", 'y'},      {"line", 'y'},       {"lines", 'y'},      {"depth", 'z'},
      {"slice", 'z'},     {"slices", 'z'},     {"plane", 'z'},      {"planes", 'z'},
      {"section", 'z'},   {"sections", 'z'},   {"lev", 'z'},        {"level", 'z'},
      {"levels", 'z'},    {"altitude", 'z'},   {"elevation", 'z'},  {"height", 'z'},
      {"time", 't'},      {"times", 't'},      {"timepoint", 't'},  {"timepoints", 't'},
      {"channel", 'c'},   {"channels", 'c'},   {"band", 'c'},       {"bands", 'c'},
      {"component", 'c'}, {"components", 'c'}, {"wavelength", 'c'}, {"member", 'c'},
      {"ensemble", 'c'},  {"realization", 'c'}};
  if (word == "height" && has_width) return 'y';
  for (const Known& known : kWords) {
    if (word == known.word) return known.letter;
  }
  // "x", "nx", "xc", "xdim", "dimx", …
  for (const char letter : {'x', 'y', 'z'}) {
    for (const std::string_view rest : {"", "dim", "axis", "coord", "pos", "c", "n"}) {
      const bool is_before = rest != "c", is_after = rest != "n";
      if (is_before && word == fmt::format("{}{}", rest, letter)) return letter;
      if (is_after && word == fmt::format("{}{}", letter, rest)) return letter;
    }
  }
  return 0;
}

}  // namespace

char axis_letter(std::string_view name, bool has_width) {
  const std::string lower = lower_case(trimmed(name));
  if (lower == "t" || lower == "c") return lower[0];
  char found = 0;
  for (const std::string& word : words_of(lower)) {
    const char letter = letter_of_word(word, has_width);
    if (letter == 0 || letter == found) continue;
    if (found != 0) return 0;
    found = letter;
  }
  return found;
}

bool place_axis(ArrayAxis& axis, const std::vector<double>& positions, double millimetres) {
  const double first = positions.front();
  const double step = (positions.back() - first) / static_cast<double>(positions.size() - 1);
  if (!std::isfinite(first) || !std::isfinite(step) || step == 0) return false;
  for (size_t i = 0; i < positions.size(); ++i) {
    const double expected = first + static_cast<double>(i) * step;
    // Positions are often 32-bit floats.
    if (!(std::abs(positions[i] - expected) <= 0.01 * std::abs(step))) return false;
  }
  axis.first = first * millimetres;
  axis.step = step * millimetres;
  return true;
}

double axis_millimetres(std::string unit, const std::string& what,
                        std::vector<std::string>& notes) {
  const auto known = millimetres_in(unit);
  if (!known) {
    notes.push_back(unit.empty() ? fmt::format("{} has no unit: mm is assumed", what)
                                 : fmt::format("the unit '{}' of {} is not known: mm is assumed",
                                               printable(unit), what));
  }
  return known.value_or(1);
}

}  // namespace isosplat::import
