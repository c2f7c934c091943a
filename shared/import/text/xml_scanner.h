#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace isosplat::import {

/// A tag of an XML text. Names have no namespace prefix: "OME:Pixels" is "Pixels".
struct XmlTag {
  std::string_view name;
  bool begins = false, ends = false;  ///< <a>: begins; </a>: ends; <a/>: both
  std::string_view attributes;        ///< as written

  /// The value of an attribute, with its entities decoded to UTF-8. Nothing if the tag lacks it.
  std::optional<std::string> attribute(std::string_view attribute_name) const;
};

/// Reads the tags of an XML text one after the other. Comments, declarations and CDATA are skipped.
/// Does not validate the text: if it is not well-formed, returns some tags, and then ends.
class XmlScanner {
 public:
  explicit XmlScanner(std::string_view text) : text_(text) {}

  /// Nothing after the last tag.
  std::optional<XmlTag> next();

  /// The text from the last tag up to the next one, with its entities decoded.
  std::string content() const;

 private:
  std::string_view text_;
  size_t at_ = 0;
};

/// Decodes &amp;, &#181;, &#xb5; and the like. Unknown entities stay as they are.
std::string without_entities(std::string_view text);

}  // namespace isosplat::import
