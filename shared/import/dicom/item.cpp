#include <algorithm>
#include <charconv>
#include <cmath>

#include "shared/import/dicom/elements.h"
#include "shared/import/text/float_from_chars.h"

// Access to the values of a data set's elements (PS3.5, 6.2).
namespace isosplat::import::dicom {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto is_padding = [](char c) { return c == ' ' || c == '\0'; };
  while (!text.empty() && is_padding(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_padding(text.back())) text.remove_suffix(1);
  return text;
}

double parse(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double number = 0;
  const auto [end, error] = float_from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = error == std::errc{} && end == text.data() + text.size();
  return whole && std::isfinite(number) ? number : std::nan("");
}

}  // namespace

const Element* Item::find(Tag tag) const {
  for (const Element& element : elements) {
    if (element.tag == tag) return &element;
  }
  return nullptr;
}

std::string_view Item::text(Tag tag) const {
  const Element* element = find(tag);
  return element ? trimmed(element->text) : std::string_view();
}

std::vector<double> Item::numbers(Tag tag) const {
  const Element* element = find(tag);
  if (!element) return {};
  if (!element->numbers.empty()) return element->numbers;
  std::vector<double> numbers;
  std::string_view rest = trimmed(element->text);
  while (!rest.empty()) {
    const size_t end = std::min(rest.find('\\'), rest.size());
    numbers.push_back(parse(rest.substr(0, end)));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return numbers;
}

std::optional<double> Item::number(Tag tag) const {
  const Element* element = find(tag);
  if (!element) return std::nullopt;
  double first = std::nan("");
  if (!element->numbers.empty()) {
    first = element->numbers.front();
  } else {
    const std::string_view text = trimmed(element->text);
    first = parse(text.substr(0, std::min(text.find('\\'), text.size())));
  }
  return std::isfinite(first) ? std::optional(first) : std::nullopt;
}

const Item* Item::first_item(Tag sequence) const {
  const Element* element = find(sequence);
  return element && !element->items.empty() ? &element->items.front() : nullptr;
}

}  // namespace isosplat::import::dicom
