#include "shared/import/vtk_xml/tags.h"

#include <algorithm>
#include <span>

namespace isosplat::import {
namespace {

constexpr size_t kMaxTag = 64 << 10;

/// Whether the text from "<" on is a whole tag, comment or declaration. `quote`: the quotation mark
/// in which the text ends; 0: none.
bool is_whole(const std::string& text, char quote) {
  if (!text.ends_with('>')) return false;
  if (text.starts_with("<!--")) return text.size() >= 7 && text.ends_with("-->");
  if (text.starts_with("<![CDATA[")) return text.ends_with("]]>");
  if (text.starts_with("<?")) return text.ends_with("?>");
  return quote == 0;
}

}  // namespace

Result<std::optional<XmlTag>> XmlTags::next() {
  const auto none = std::optional<XmlTag>();
  words_ = 0;
  bool in_word = false;
  for (;;) {
    for (;;) {  // the text before the tag
      const auto more = fill();
      if (!more) return tl::unexpected(more.error());
      if (!*more) return none;
      for (; next_ < filled_ && buffer_[next_] != '<'; ++next_) {
        const char c = buffer_[next_];
        const bool separates = c == ' ' || (c >= '\t' && c <= '\r');
        words_ += !separates && !in_word;
        in_word = !separates;
      }
      if (next_ < filled_) break;
    }
    begin_ = end();
    text_.clear();
    for (char quote = 0; !is_whole(text_, quote);) {
      const auto more = fill();
      if (!more) return tl::unexpected(more.error());
      if (!*more || text_.size() == kMaxTag) return none;
      const char c = buffer_[next_++];
      text_.push_back(c);
      if (quote == 0 ? c == '"' || c == '\'' : c == quote) quote = quote == 0 ? c : 0;
    }
    if (!text_.starts_with("<!") && !text_.starts_with("<?")) return XmlScanner(text_).next();
  }
}

/// Whether there are more characters; reads them if the buffer is used up.
Result<bool> XmlTags::fill() {
  if (next_ < filled_) return true;
  const uint64_t size = file_.size_limit();
  const auto some =
      static_cast<size_t>(std::min<uint64_t>(buffer_.size(), size - std::min(size, position_)));
  if (some == 0) return false;
  const auto read = file_.read(position_, std::as_writable_bytes(std::span(buffer_).first(some)));
  if (!read) return tl::unexpected(read.error());
  position_ += some;
  next_ = 0;
  filled_ = some;
  return true;
}

}  // namespace isosplat::import
