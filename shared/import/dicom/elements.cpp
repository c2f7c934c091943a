#include "shared/import/dicom/elements.h"

#include <array>
#include <cstring>
#include <map>
#include <span>
#include <utility>

#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/dicom/element_encoding.h"
#include "shared/import/dicom/element_input.h"

namespace isosplat::import::dicom {
namespace {

constexpr Tag kItem = 0xfffee000;
constexpr Tag kItemEnd = 0xfffee00d;
constexpr Tag kSequenceEnd = 0xfffee0dd;

/// Limits for the length of a value, the number of elements of a file and the nesting of sequences.
/// They are hundreds of times the sizes in real files.
constexpr uint64_t kMaxValueBytes = 4 << 20;
constexpr size_t kMaxElements = 4'000'000;
constexpr int kMaxDepth = 32;

/// Reads a data set from front to back.
class ElementReader {
 public:
  /// `end`: the end of the bytes; unknown for deflated data.
  ElementReader(ByteReader& file, const std::filesystem::path& path, uint64_t start,
                std::optional<uint64_t> end)
      : in_(file, path, start, end) {}

  uint64_t position() const { return in_.position(); }

  /// Reads the elements of group 2, which contain the transfer syntax.
  Result<void> read_meta(Item& out) {
    for (;;) {
      auto next = peek_tag();
      if (!next) return tl::unexpected(next.error());
      if (!*next || **next >> 16 != 2) return {};
      auto read = read_element(Syntax{}, &out, in_.end(), 0);
      if (!read) return tl::unexpected(read.error());
    }
  }

  /// Detects the encoding of the data set that starts here, independent of the transfer syntax:
  /// some programs write a different encoding than they declare.
  Result<Syntax> guess_syntax(Syntax promised) {
    std::array<std::byte, 6> bytes{};
    const auto room = in_.has(bytes.size());
    if (!room) return tl::unexpected(room.error());
    if (!*room) return promised;
    if (auto r = in_.look(bytes); !r) return tl::unexpected(r.error());
    const uint16_t group = u16_at(bytes.data(), promised.big_endian);
    if (group > 0xff && __builtin_bswap16(group) <= 0xff) promised.big_endian ^= true;
    promised.is_explicit = is_vr({reinterpret_cast<const char*>(bytes.data()) + 4, 2});
    return promised;
  }

  /// Reads the data set up to its pixels.
  Result<void> read_data(Syntax syntax, Elements& out) {
    pixels_ = &out.pixels;
    while (out.pixels.tag == 0) {
      auto next = peek_tag();
      if (!next) return tl::unexpected(next.error());
      if (!*next) return in_.check_end();
      if (**next == 0) return {};  // zero padding at the end of the file
      auto read = read_element(syntax, &out.data, in_.end(), 0);
      if (!read) return read;
    }
    return {};
  }

 private:
  /// The next tag, in the byte order that gives a group below 0x100; nothing at the end.
  Result<std::optional<Tag>> peek_tag() {
    std::array<std::byte, 4> bytes{};
    const auto room = in_.has(bytes.size());
    if (!room) return tl::unexpected(room.error());
    if (!*room) return std::nullopt;
    if (auto r = in_.look(bytes); !r) return tl::unexpected(r.error());
    return tag_at(bytes.data(), false);
  }

  /// Reads one element into `out`, or skips it if `out` is null or the element is not in the list.
  /// `end`: of the enclosing item.
  Result<void> read_element(Syntax syntax, Item* out, uint64_t end, int depth) {
    const auto header = read_header(in_, syntax, end);
    if (!header) return tl::unexpected(header.error());
    const bool is_pixels =
        header->tag == kPixels || header->tag == kFloatPixels || header->tag == kDoublePixels;
    if (is_pixels && depth == 0 && pixels_) {
      pixels_->tag = header->tag;
      pixels_->in_words = header->is_vr("OW");
      pixels_->offset = in_.position();
      pixels_->bytes =
          header->length == kUndefinedLength ? PixelPlace::kUndefined : uint64_t{header->length};
      return {};
    }
    if (header->tag >> 16 == 0xfffe) return in_.malformed("an item where an element should be");

    const KnownTag* known = out ? find_known_tag(header->tag) : nullptr;
    if (out && depth == 0 && header->tag >> 16 & 1) {
      const auto found = find_private(*header);
      if (!found) return tl::unexpected(found.error());
      known = *found;
    }
    const bool is_sequence =
        header->length == kUndefinedLength ||
        (known && kind_of(*header, known->kind) == Kind::sequence && header->length > 0);
    if (is_sequence) {
      Element element;
      element.tag = known ? known->tag : header->tag;
      // A sequence with unknown VR is in the implicit form (PS3.5, 6.2.2).
      const Syntax inside =
          header->is_vr("UN") ? Syntax{.is_explicit = false, .big_endian = false} : syntax;
      auto read = read_sequence(inside, *header, known ? &element : nullptr, end, depth + 1);
      if (!read) return read;
      return known ? keep(*out, std::move(element)) : Result<void>{};
    }
    const auto room = in_.has(header->length);
    if (!room) return tl::unexpected(room.error());
    if (!*room) return in_.ends_early(header->tag, header->length);
    if (header->length > end - in_.position()) {
      return in_.malformed("a value crosses the end of its item");
    }
    if (!known) {
      in_.move_to(in_.position() + header->length);
      return {};
    }
    if (header->length > kMaxValueBytes) {
      return in_.malformed(name_of(header->tag) + " is too long");
    }
    std::vector<std::byte> bytes(header->length);
    if (auto r = in_.read(bytes); !r) return r;
    return keep(*out, make_element(syntax, known->tag, kind_of(*header, known->kind), bytes));
  }

  /// How a private element is stored. Remembers the creator of a block, which precedes the block's
  /// elements: (gggg,00bb) reserves (gggg,bb00) to (gggg,bbff).
  Result<const KnownTag*> find_private(const ElementHeader& header) {
    const Tag group = header.tag & 0xffff0000, element = header.tag & 0xffff;
    const auto room = in_.has(header.length);
    if (!room) return tl::unexpected(room.error());
    if (element >= 0x10 && element <= 0xff && header.length <= kMaxCreator && *room) {
      std::vector<std::byte> bytes(header.length);
      if (auto r = in_.look(bytes); !r) return tl::unexpected(r.error());
      std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      text.erase(text.find_last_not_of(std::string_view(" \0", 2)) + 1);
      creators_[group | element << 8] = std::move(text);
      return nullptr;
    }
    const auto creator = creators_.find(header.tag & 0xffffff00);
    if (creator == creators_.end() || header.length > kMaxValueBytes) return nullptr;
    return find_private_tag(creator->second, header.tag);
  }

  Result<void> keep(Item& out, Element element) {
    if (++kept_ > kMaxElements) return in_.malformed("it has too many elements");
    out.elements.push_back(std::move(element));
    return {};
  }

  /// Reads the items of a sequence, or the fragments of an encapsulated value, after its header;
  /// skips them if `out` is null.
  Result<void> read_sequence(Syntax syntax, const ElementHeader& header, Element* out,
                             uint64_t outer_end, int depth) {
    if (depth > kMaxDepth) return in_.malformed("its sequences are nested too deeply");
    uint64_t end = outer_end;
    if (header.length != kUndefinedLength) {
      const auto room = in_.has(header.length);
      if (!room) return tl::unexpected(room.error());
      if (!*room) return in_.ends_early(header.tag, header.length);
      if (header.length > outer_end - in_.position()) {
        return in_.malformed("a sequence crosses its item's end");
      }
      end = in_.position() + header.length;
    }
    while (in_.position() < end) {
      const auto item = read_header(in_, syntax, end);
      if (!item) return tl::unexpected(item.error());
      if (item->tag == kSequenceEnd) return {};
      if (item->tag != kItem) return in_.malformed("expected an item of " + name_of(header.tag));
      Item* inside = nullptr;
      if (out) {
        if (++kept_ > kMaxElements) return in_.malformed("it has too many elements");
        inside = &out->items.emplace_back();
      }
      if (auto r = read_item(syntax, *item, inside, end, depth); !r) return r;
    }
    if (header.length == kUndefinedLength) return in_.ends_early(header.tag, 8);
    return {};
  }

  Result<void> read_item(Syntax syntax, const ElementHeader& item, Item* out, uint64_t sequence_end,
                         int depth) {
    if (item.length != kUndefinedLength) {
      const auto room = in_.has(item.length);
      if (!room) return tl::unexpected(room.error());
      if (!*room) return in_.ends_early(kItem, item.length);
      if (item.length > sequence_end - in_.position()) {
        return in_.malformed(
            "an item crosses the end of its "
            "sequence");
      }
      const uint64_t end = in_.position() + item.length;
      while (out && in_.position() < end) {
        if (auto r = read_element(syntax, out, end, depth); !r) return r;
      }
      in_.move_to(end);
      return {};
    }
    for (;;) {
      const auto room = in_.has(8);
      if (!room) return tl::unexpected(room.error());
      if (!*room) return in_.ends_early(kItemEnd, 8);
      std::array<std::byte, 4> bytes{};
      if (auto r = in_.look(bytes); !r) return r;
      const Tag tag = tag_at(bytes.data(), syntax.big_endian);
      if (tag == kItemEnd) {
        in_.move_to(in_.position() + 8);
        return {};
      }
      if (auto r = read_element(syntax, out, sequence_end, depth); !r) return r;
    }
  }

  static constexpr uint32_t kMaxCreator = 64;

  ElementInput in_;
  PixelPlace* pixels_ = nullptr;
  size_t kept_ = 0;
  std::map<Tag, std::string> creators_;  ///< of private blocks, by their first tag
};

}  // namespace

bool looks_like_dicom(std::string_view beginning) {
  if (beginning.size() >= 132 && beginning.substr(128, 4) == "DICM") return true;
  if (beginning.size() < 16) return false;
  // Without a prefix, the first element has group 2 or 8, and a VR or a small even length.
  const auto* bytes = reinterpret_cast<const std::byte*>(beginning.data());
  for (const bool big_endian : {false, true}) {
    const uint16_t group = u16_at(bytes, big_endian);
    const uint16_t element = u16_at(bytes + 2, big_endian);
    if ((group != 2 && group != 8) || element > 0x70) continue;
    if (is_vr(beginning.substr(4, 2))) return true;
    const uint32_t length = u32_at(bytes + 4, big_endian);
    if (length <= 128 && length % 2 == 0 && 8 + length < beginning.size()) {
      const uint16_t next = u16_at(bytes + 8 + length, big_endian);
      if (next == group || next == 8) return true;
    }
  }
  return false;
}

Result<Elements> read_elements(const std::filesystem::path& path) {
  auto opened = open_plain(path);
  if (!opened) return tl::unexpected(opened.error());
  ByteReader& file = **opened;
  std::array<std::byte, 132> prefix{};
  const uint64_t size = file.size_limit();
  uint64_t start = 0;
  if (size >= prefix.size()) {
    if (auto r = file.read(0, prefix); !r) return tl::unexpected(r.error());
    if (std::memcmp(prefix.data() + 128, "DICM", 4) == 0) start = prefix.size();
  }
  Elements out;
  ElementReader walker(file, path, start, size);
  if (auto r = walker.read_meta(out.data); !r) return tl::unexpected(r.error());
  out.transfer_syntax = out.data.text(kTransferSyntax);
  const std::string& uid = out.transfer_syntax;
  Syntax syntax;
  syntax.is_explicit = uid != "1.2.840.10008.1.2" && uid != "1.2.840.113619.5.2";
  syntax.big_endian = uid == "1.2.840.10008.1.2.2";
  if (uid == "1.2.840.10008.1.2.1.99") {
    out.deflated = true;
    out.deflated_start = walker.position();
    auto inflated = open_deflated(path, out.deflated_start, Deflate::raw);
    if (!inflated) return tl::unexpected(inflated.error());
    ElementReader inner(**inflated, path, 0, std::nullopt);
    if (auto r = inner.read_data(syntax, out); !r) return tl::unexpected(r.error());
    return out;
  }
  const auto found = walker.guess_syntax(syntax);
  if (!found) return tl::unexpected(found.error());
  if (auto r = walker.read_data(*found, out); !r) return tl::unexpected(r.error());
  if (uid.empty()) {
    out.transfer_syntax = found->big_endian    ? "1.2.840.10008.1.2.2"
                          : found->is_explicit ? "1.2.840.10008.1.2.1"
                                               : "1.2.840.10008.1.2";
  }
  return out;
}

}  // namespace isosplat::import::dicom
