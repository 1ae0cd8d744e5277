#pragma once

// XML files as trees whose elements know their lines.

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/vec.h"

namespace scanmill {

struct XmlNode {
  Location where;
  std::string name;
  std::string text;  // the text of the element itself, trimmed
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<XmlNode> children;

  const XmlNode* child(std::string_view childName) const;          // the first child of that name, or null
  const std::string* attribute(std::string_view attribute) const;  // or null
  std::string attributeOr(std::string_view attribute, std::string_view fallback) const;
  std::string textOf(std::string_view childName, std::string_view fallback) const;

  // Throws InputError at this element.
  [[noreturn]] void fail(const std::string& what) const;
};

// Reads a file. Throws InputError with the file and its line if it is not XML, or nested deeper than 64 elements.
XmlNode readXml(const std::filesystem::path& file);

// Returns exactly `count` finite numbers of a text that are separated by spaces. Throws InputError at `node`.
std::vector<double> numbersIn(const XmlNode& node, std::string_view text, std::size_t count);
Vec3d vectorIn(const XmlNode& node, std::string_view text);

}  // namespace scanmill
