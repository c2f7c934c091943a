#include "shared/import/slices/slice_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "shared/import/slices/slice_files.h"
#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

/// A file name, split into its numbers and the rest.
struct Name {
  size_t file = 0;
  std::string shape;  ///< the name with # for each number
  std::vector<std::string> numbers;
};

/// The syntax of a number: digits; or digits with a sign and decimals.
enum class Numbers : uint8_t { whole, decimal };

/// Size of the number that begins at text[at]; 0 if none does.
size_t number_size(std::string_view text, size_t at, Numbers kind) {
  const auto digits_from = [&](size_t from) {
    size_t end = from;
    while (end < text.size() && text[end] >= '0' && text[end] <= '9') ++end;
    return end - from;
  };
  const bool has_sign = kind == Numbers::decimal && (text[at] == '-' || text[at] == '+');
  const size_t first = at + (has_sign ? 1 : 0);
  const size_t whole = digits_from(first);
  if (whole == 0) return 0;
  size_t end = first + whole;
  if (kind == Numbers::decimal && end < text.size() && text[end] == '.') {
    const size_t decimals = digits_from(end + 1);
    if (decimals > 0) end += 1 + decimals;
  }
  return end - at;
}

Name take_numbers(const std::string& text, size_t file, Numbers kind) {
  Name name;
  name.file = file;
  for (size_t at = 0; at < text.size();) {
    const size_t size = number_size(text, at, kind);
    if (size == 0) {
      name.shape.push_back(text[at++]);
      continue;
    }
    name.shape.push_back('#');
    name.numbers.push_back(text.substr(at, size));
    at += size;
  }
  return name;
}

std::vector<Name> names_of(const std::vector<std::filesystem::path>& files, Numbers kind) {
  std::vector<Name> names;
  for (size_t i = 0; i < files.size(); ++i) {
    names.push_back(take_numbers(files[i].stem().string(), i, kind));
  }
  return names;
}

bool have_one_shape(const std::vector<Name>& names) {
  return std::all_of(names.begin(), names.end(),
                     [&](const Name& n) { return n.shape == names[0].shape; });
}

/// The values of one number in all names. A number that exceeds the range of a double counts as 0.
using Values = std::vector<double>;

Values values_of(const std::vector<Name>& names, size_t field) {
  Values values;
  for (const Name& name : names) values.push_back(number_in(name.numbers[field]).value_or(0));
  return values;
}

std::vector<size_t> sorted_by(const std::vector<const Values*>& fields, size_t count) {
  std::vector<size_t> order(count);
  for (size_t i = 0; i < count; ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    for (const Values* field : fields) {
      if ((*field)[a] != (*field)[b]) return (*field)[a] < (*field)[b];
    }
    return false;
  });
  return order;
}

bool all_differ(Values values) {
  std::sort(values.begin(), values.end());
  return std::adjacent_find(values.begin(), values.end()) == values.end();
}

bool all_equal(const Values& values) {
  return std::all_of(values.begin(), values.end(), [&](double v) { return v == values[0]; });
}

/// The distance between neighbouring numbers, if it is constant except for gaps, which are
/// multiples of it. `gaps`: number of missing slices. Nothing if there is no such distance.
std::optional<double> even_step(Values values, uint64_t& gaps) {
  std::sort(values.begin(), values.end());
  double step = values[1] - values[0];
  for (size_t i = 1; i < values.size(); ++i) step = std::min(step, values[i] - values[i - 1]);
  gaps = 0;
  for (size_t i = 1; i < values.size(); ++i) {
    const double steps = (values[i] - values[i - 1]) / step;
    if (!(std::abs(steps - std::round(steps)) < 1e-3) || steps > 1e6) return std::nullopt;
    gaps += static_cast<uint64_t>(std::round(steps)) - 1;
  }
  return step;
}

tl::unexpected<Error> ambiguous_order(const std::filesystem::path& folder,
                                      const std::string& what) {
  return fail(Status::malformed_volume,
              fmt::format("{}: the order of its slices is ambiguous: {}", folder.string(), what));
}

/// Joins the parts of decimal numbers ("z#.#", if both parts vary) into one number. Errors: if the
/// order differs from that of the parts as whole numbers.
Result<void> join_decimals(const std::filesystem::path& folder, std::vector<Name>& names) {
  for (;;) {
    const size_t point = names[0].shape.find("#.#");
    if (point == std::string::npos) return {};
    const auto field = static_cast<size_t>(std::count(
        names[0].shape.begin(), names[0].shape.begin() + static_cast<std::ptrdiff_t>(point), '#'));
    const Values whole = values_of(names, field), part = values_of(names, field + 1);
    std::vector<Name> joined = names;
    for (Name& name : joined) {
      name.numbers[field].append(1, '.').append(name.numbers[field + 1]);
      name.numbers.erase(name.numbers.begin() + static_cast<std::ptrdiff_t>(field) + 1);
      name.shape.erase(point + 1, 2);
    }
    if (all_equal(whole) || all_equal(part)) {  // independent numbers; hide the point
      for (Name& name : names) name.shape[point + 1] = ' ';
      continue;
    }
    const Values decimal = values_of(joined, field);
    if (sorted_by({&whole, &part}, names.size()) != sorted_by({&decimal}, names.size())) {
      return ambiguous_order(
          folder,
          "it depends on whether the numbers in the names are decimals, as in 1.5 and "
          "1.25: use the same number of digits in all names");
    }
    names = std::move(joined);
  }
}

/// The error if some names share a pattern of text and numbers, but not all.
Result<void> check_no_shared_pattern(const std::filesystem::path& folder,
                                     const std::vector<std::filesystem::path>& files,
                                     const std::vector<Name>& names) {
  std::map<std::string, std::vector<size_t>> kinds;
  for (const Name& name : names) kinds[name.shape].push_back(name.file);
  if (kinds.size() == files.size()) return {};
  const auto one = kinds.begin();
  const auto other = std::next(one);
  return ambiguous_order(folder,
                         fmt::format("the names have {} different patterns, such as {} and "
                                     "{}: keep only the files of one stack in the folder",
                                     kinds.size(), files[one->second[0]].filename().string(),
                                     files[other->second[0]].filename().string()));
}

/// The order of the slices by the numbers in their names.
struct Numbering {
  std::vector<size_t> order;  ///< indices of the files
  Values values;              ///< the numbers that count the slices, one for each file
  uint64_t gaps = 0;          ///< number of missing slices; kUneven: no constant step
};

constexpr uint64_t kUneven = UINT64_MAX;

/// Finds the number in the names that counts the slices. If several do, one without gaps is chosen.
Result<Numbering> find_numbering(const std::filesystem::path& folder,
                                 const std::vector<Name>& names) {
  std::vector<Values> fields;
  for (size_t i = 0; i < names[0].numbers.size(); ++i) {
    Values values = values_of(names, i);
    if (!all_equal(values)) fields.push_back(std::move(values));
  }
  std::vector<const Values*> all;
  for (const Values& field : fields) all.push_back(&field);
  Numbering numbering;
  numbering.order = sorted_by(all, names.size());
  for (const Values& field : fields) {
    if (!all_differ(field)) continue;
    if (sorted_by({&field}, names.size()) != numbering.order) {
      return ambiguous_order(
          folder,
          "the names have several numbers that give different orders: keep one varying number");
    }
    uint64_t gaps = 0;
    const bool even = even_step(field, gaps).has_value();
    if (numbering.values.empty() || (even && gaps == 0)) {
      numbering.values = field;
      numbering.gaps = even ? gaps : kUneven;
    }
  }
  if (numbering.values.empty()) {
    return ambiguous_order(
        folder,
        "several numbers in the names vary independently (times or channels, and "
        "slices?): give the folder of one stack");
  }
  return numbering;
}

/// The files in order, with an empty path for each missing slice if there are few enough of them.
Result<SliceOrder> place_slices(const std::filesystem::path& folder,
                                std::vector<std::filesystem::path> files,
                                const Numbering& numbering, Allowances allowed) {
  const auto& [order, values, gaps] = numbering;
  if (gaps > 0 && !allowed.has(Allowance::gaps)) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected evenly numbered slices, found {}: add the missing "
                            "slices, or read without them with {}",
                            folder.string(),
                            gaps == kUneven ? "uneven numbers"
                                            : fmt::format("{} missing between them", gaps),
                            flag_of(Allowance::gaps)));
  }
  SliceOrder result;
  const bool fills = gaps > 0 && gaps <= 16 * files.size();
  if (fills) {
    result.notes.push_back(fmt::format("{} slices are missing: their voxels have no value", gaps));
  } else if (gaps > 0) {
    result.notes.push_back("the slices are not numbered evenly: even distances are assumed");
  }
  uint64_t ignored = 0;
  const double step = fills ? *even_step(values, ignored) : 1;
  for (size_t i = 0; i < order.size(); ++i) {
    if (fills && i > 0) {
      const double apart = (values[order[i]] - values[order[i - 1]]) / step;
      for (int64_t k = 1; k < std::llround(apart); ++k) result.slices.emplace_back();
    }
    result.slices.push_back(std::move(files[order[i]]));
  }
  return result;
}

}  // namespace

Result<SliceOrder> order_slices(const std::filesystem::path& folder,
                                std::vector<std::filesystem::path> files, Allowances allowed) {
  std::vector<Name> names = names_of(files, Numbers::whole);
  if (!have_one_shape(names)) {
    std::vector<Name> with_signs = names_of(files, Numbers::decimal);
    if (!have_one_shape(with_signs)) {
      if (auto checked = check_no_shared_pattern(folder, files, names); !checked) {
        return tl::unexpected(checked.error());
      }
      std::sort(files.begin(), files.end());
      return SliceOrder{
          std::move(files),
          {"the slices' names have no common pattern: they are sorted alphabetically"}};
    }
    names = std::move(with_signs);
  } else if (names[0].numbers.empty() && files.size() > 1) {
    return ambiguous_order(folder, "the names have no numbers: add numbers");
  }
  if (files.size() < 2) return SliceOrder{std::move(files), {}};
  if (auto joined = join_decimals(folder, names); !joined) return tl::unexpected(joined.error());
  const auto numbering = find_numbering(folder, names);
  if (!numbering) return tl::unexpected(numbering.error());
  return place_slices(folder, std::move(files), *numbering, allowed);
}

}  // namespace isosplat::import
