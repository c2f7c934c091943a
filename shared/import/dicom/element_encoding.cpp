#include "shared/import/dicom/element_encoding.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <vector>

namespace isosplat::import::dicom {
namespace {

constexpr std::string_view kLongForms[] = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                           "SV", "UC", "UN", "UR", "UT", "UV"};
constexpr std::string_view kShortForms[] = {"AE", "AS", "AT", "CS", "DA", "DS", "DT",
                                            "FD", "FL", "IS", "LO", "LT", "PN", "SH",
                                            "SL", "SS", "ST", "TM", "UI", "UL", "US"};

template <size_t N>
bool contains(const std::string_view (&names)[N], std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

template <class T>
void append_numbers(std::span<const std::byte> bytes, bool big_endian, std::vector<double>& out) {
  for (size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    std::array<std::byte, sizeof(T)> raw;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), sizeof(T), raw.begin());
    if (big_endian) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    out.push_back(static_cast<double>(value));
  }
}

}  // namespace

bool is_vr(std::string_view name) {
  return contains(kLongForms, name) || contains(kShortForms, name);
}

Result<ElementHeader> read_header(ElementInput& in, Syntax syntax, uint64_t end) {
  ElementHeader header;
  std::array<std::byte, 8> bytes{};
  const auto room = in.has(bytes.size());
  if (!room) return tl::unexpected(room.error());
  if (!*room) return in.ends_early(0, bytes.size());
  if (in.position() + bytes.size() > end) {
    return in.malformed("an element crosses the end of its item");
  }
  if (auto r = in.read(bytes); !r) return tl::unexpected(r.error());
  header.tag = tag_at(bytes.data(), syntax.big_endian);
  const std::string_view vr(reinterpret_cast<const char*>(bytes.data()) + 4, 2);
  const bool is_delimiter = header.tag >> 16 == 0xfffe;
  // Some writers mix both forms. If these bytes are not a VR, they are the length of the implicit
  // form.
  if (is_delimiter || !syntax.is_explicit || !is_vr(vr)) {
    header.length = u32_at(bytes.data() + 4, syntax.big_endian);
    return header;
  }
  header.vr = {vr[0], vr[1]};
  if (!contains(kLongForms, vr)) {
    header.length = u16_at(bytes.data() + 6, syntax.big_endian);
    return header;
  }
  std::array<std::byte, 4> length{};
  const auto more = in.has(length.size());
  if (!more) return tl::unexpected(more.error());
  if (!*more) return in.ends_early(header.tag, length.size());
  if (auto r = in.read(length); !r) return tl::unexpected(r.error());
  header.length = u32_at(length.data(), syntax.big_endian);
  return header;
}

Kind kind_of(const ElementHeader& header, Kind registered) {
  struct Named {
    std::string_view vr;
    Kind kind;
  };
  constexpr Named kNamed[] = {{"US", Kind::u16},     {"SS", Kind::i16}, {"UL", Kind::u32},
                              {"SL", Kind::i32},     {"FL", Kind::f32}, {"FD", Kind::f64},
                              {"SQ", Kind::sequence}};
  if (header.vr[0] == 0 || header.is_vr("UN") || header.is_vr("OB") || header.is_vr("OW")) {
    return registered;
  }
  for (const Named& named : kNamed) {
    if (header.is_vr(named.vr)) return named.kind;
  }
  return Kind::text;
}

Element make_element(Syntax syntax, Tag tag, Kind kind, std::span<const std::byte> bytes) {
  Element element;
  element.tag = tag;
  const bool swap = syntax.big_endian;
  switch (kind) {
    case Kind::text:
      element.text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      break;
    case Kind::u16:
      append_numbers<uint16_t>(bytes, swap, element.numbers);
      break;
    case Kind::i16:
      append_numbers<int16_t>(bytes, swap, element.numbers);
      break;
    case Kind::u32:
      append_numbers<uint32_t>(bytes, swap, element.numbers);
      break;
    case Kind::i32:
      append_numbers<int32_t>(bytes, swap, element.numbers);
      break;
    case Kind::f32:
      append_numbers<float>(bytes, swap, element.numbers);
      break;
    case Kind::f64:
      append_numbers<double>(bytes, swap, element.numbers);
      break;
    case Kind::sequence:
      break;
  }
  return element;
}

}  // namespace isosplat::import::dicom
