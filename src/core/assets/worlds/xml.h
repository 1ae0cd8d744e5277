#pragma once

// XML files as trees of elements with their line numbers.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/format_support.h"
#include "base/vec.h"

namespace scanmill {

struct XmlNode {
  Location where;
  std::string name;
  std::string text;  // text of the element without its children, trimmed
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<XmlNode> children;

  const XmlNode* child(std::string_view childName) const;          // first child with this name; null: none
  const std::string* attribute(std::string_view attribute) const;  // returns null if the attribute is absent
  std::string attributeOr(std::string_view attribute, std::string_view fallback) const;
  // Returns the text of the first child with this name; `fallback` if there is none.
  std::string textOf(std::string_view childName, std::string_view fallback) const;

  // Throws InputError at this element.
  template <class... Values>
  [[noreturn]] void fail(fmt::format_string<Values...> problem, Values&&... values) const {
    throw InputError(where, "<{}> {}", name, fmt::format(problem, std::forward<Values>(values)...));
  }
};

// Reads a file. Throws InputError with the file and its line if it is not XML, is nested deeper than 64 elements, or is
// a template or names a file to include, which other programs must expand first.
XmlNode readXml(const std::filesystem::path& file);

// numbersIn() returns the `count` numbers in a text, separated by white space; vectorIn() expects three. Both throw
// InputError at `node` if their number differs or one is not finite.
std::vector<double> numbersIn(const XmlNode& node, std::string_view text, std::size_t count);
Vec3d vectorIn(const XmlNode& node, std::string_view text);

// Names of elements, and names of the parents in which these elements may stand, each list separated by blanks.
struct ElementPlace {
  std::string_view names;
  std::string_view parents;
  bool isMany = false;  // false: of all elements with these names, a parent may have one
};

// Counts the children of an element that may not stand in it, and repeated children where only one may stand. Elements
// that are not in the table may stand anywhere.
void countMisplaced(const XmlNode& parent, std::span<const ElementPlace> places, LeftOut& leftOut);

}  // namespace scanmill
