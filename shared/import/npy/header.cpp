#include "shared/import/npy/header.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "shared/import/text/header_text.h"
#include "shared/import/volume/refusals.h"

namespace isosplat::import {
namespace {

/// Reads the tokens of a Python literal. If the next token is of another kind, a function returns
/// nothing or false, and does not advance.
class Literal {
 public:
  explicit Literal(std::string_view text) : rest_(text) {}

  bool take(char c) {
    skip_space();
    if (!rest_.starts_with(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }

  bool take_word(std::string_view word) {
    skip_space();
    if (!rest_.starts_with(word)) return false;
    rest_.remove_prefix(word.size());
    return true;
  }

  /// A string in single or double quotes, of at most 40 printable characters without escapes.
  std::optional<std::string_view> string() {
    skip_space();
    if (rest_.empty() || (rest_[0] != '\'' && rest_[0] != '"')) return std::nullopt;
    const size_t end = rest_.find(rest_[0], 1);
    if (end == rest_.npos) return std::nullopt;
    const std::string_view text = rest_.substr(1, end - 1);
    const bool is_plain = std::all_of(text.begin(), text.end(),
                                      [](char c) { return c >= ' ' && c <= '~' && c != '\\'; });
    if (text.size() > 40 || !is_plain) return std::nullopt;
    rest_.remove_prefix(end + 1);
    return text;
  }

  /// A whole number from 0 on; Python 2 wrote some with an L.
  std::optional<int64_t> size() {
    skip_space();
    const size_t end = std::min(rest_.find_first_not_of("0123456789"), rest_.size());
    const auto number = whole_number(rest_.substr(0, end));
    if (!number) return std::nullopt;
    rest_.remove_prefix(end);
    if (rest_.starts_with('L')) rest_.remove_prefix(1);
    return number;
  }

  /// Up to 40 bytes of the remaining text, for messages.
  std::string next() {
    skip_space();
    std::string text(rest_.substr(0, std::min<size_t>(40, rest_.find('\n'))));
    for (char& c : text) {
      if (c < ' ' || c > '~') c = '?';
    }
    return text.empty() ? "the end" : "'" + text + "'";
  }

  bool is_at_end() {
    skip_space();
    return rest_.empty();
  }

 private:
  void skip_space() {
    while (!rest_.empty() && (rest_[0] == ' ' || rest_[0] == '\n')) rest_.remove_prefix(1);
  }

  std::string_view rest_;
};

/// The maximum number of axes of an array. NumPy has the same limit.
constexpr size_t kMaxAxes = 64;

/// A tuple of sizes: (), (3,), (3, 4) or (3, 4, ).
std::optional<std::vector<int64_t>> tuple_of_sizes(Literal& literal) {
  if (!literal.take('(')) return std::nullopt;
  std::vector<int64_t> sizes;
  bool ends_with_comma = true;
  while (!literal.take(')')) {
    const auto size = literal.size();
    if (!size || !ends_with_comma || sizes.size() == kMaxAxes) return std::nullopt;
    sizes.push_back(*size);
    ends_with_comma = literal.take(',');
  }
  // (3) is a number in Python.
  if (sizes.size() == 1 && !ends_with_comma) return std::nullopt;
  return sizes;
}

}  // namespace

tl::unexpected<Error> malformed_npy(const std::filesystem::path& path, const std::string& what) {
  return fail(Status::malformed_volume,
              fmt::format("{}: {}: the file is damaged, or not from NumPy; save the array again",
                          path.string(), what));
}

Result<NpyHeader> parse_npy_dictionary(const std::filesystem::path& path, std::string_view text) {
  Literal literal(text);
  const auto expected = [&](const char* what) {
    return malformed_npy(path,
                         fmt::format("expected {} in the header, found {}", what, literal.next()));
  };
  if (!literal.take('{')) return expected("a dictionary");
  NpyHeader header;
  bool has_type = false, has_order = false, has_shape = false, ends_with_comma = true;
  while (!literal.take('}')) {
    if (!ends_with_comma) return expected("a comma");
    const auto key = literal.string();
    if (!key) return expected("a key");
    if (!literal.take(':')) return expected("a colon");
    if (*key == "descr" && !has_type) {
      if (literal.take('[')) return unknown_type(path, "a NumPy array of records");
      const auto type = literal.string();
      if (!type) return expected("a type");
      header.type = *type;
      has_type = true;
    } else if (*key == "fortran_order" && !has_order) {
      header.fortran_order = literal.take_word("True");
      if (!header.fortran_order && !literal.take_word("False")) return expected("True or False");
      has_order = true;
    } else if (*key == "shape" && !has_shape) {
      const auto shape = tuple_of_sizes(literal);
      if (!shape) return expected("a tuple of sizes");
      header.shape = *shape;
      has_shape = true;
    } else {
      return malformed_npy(path,
                           "expected the keys descr, fortran_order and shape once each, "
                           "found another or one twice");
    }
    ends_with_comma = literal.take(',');
  }
  if (!literal.is_at_end()) return expected("the end");
  if (!has_type || !has_order || !has_shape) {
    return malformed_npy(path, "expected the keys descr, fortran_order and shape, found fewer");
  }
  return header;
}

}  // namespace isosplat::import
