#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>
#include <system_error>

namespace isosplat::import {

/// std::from_chars for float and double. The C++ library for WebAssembly has it only for integers;
/// there, strtof and strtod parse the texts that from_chars accepts.
template <class T>
std::from_chars_result float_from_chars(const char* first, const char* last, T& value) {
#ifndef _LIBCPP_VERSION
  return std::from_chars(first, last, value);
#else
  std::string text(first, last);
  const size_t sign = text.starts_with('-') ? 1 : 0;
  // from_chars does not accept hexadecimal numbers, white space or plus signs.
  if (text.size() > sign + 1 && text[sign] == '0' && (text[sign + 1] | 0x20) == 'x') {
    text.resize(sign + 1);
  }
  const char begin = text.size() > sign ? text[sign] : ' ';
  const bool is_number = (begin >= '0' && begin <= '9') || begin == '.';
  const bool is_named = (begin | 0x20) == 'i' || (begin | 0x20) == 'n';
  if (!is_number && !is_named) return {first, std::errc::invalid_argument};
  char* end = nullptr;
  T found{};
  if constexpr (sizeof(T) == sizeof(float)) {
    found = std::strtof(text.c_str(), &end);
  } else {
    found = std::strtod(text.c_str(), &end);
  }
  if (end == text.c_str()) return {first, std::errc::invalid_argument};
  const auto used = static_cast<size_t>(end - text.c_str());
  const std::string digits = text.substr(0, std::min(used, text.find_first_of("eE")));
  const bool is_zero = digits.find_first_of("123456789") == digits.npos;
  if (is_number && (std::isinf(found) || (found == 0 && !is_zero))) {
    return {first + used, std::errc::result_out_of_range};
  }
  value = found;
  return {first + used, std::errc{}};
#endif
}

}  // namespace isosplat::import
