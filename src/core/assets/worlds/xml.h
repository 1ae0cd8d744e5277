#pragma once

// XML files as trees whose every element knows its line.

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
  std::string text;  // of the element itself, without spaces around it
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<XmlNode> children;

  const XmlNode* child(std::string_view childName) const;          // the first of that name, or null
  const std::string* attribute(std::string_view attribute) const;  // or null
  std::string attributeOr(std::string_view attribute, std::string_view fallback) const;
  std::string textOf(std::string_view childName, std::string_view fallback) const;

  // Throws InputError at this element.
  [[noreturn]] void fail(const std::string& what) const;
};

// Throws InputError with the file and its line where it is no XML, or deeper than 64 elements.
XmlNode readXml(const std::filesystem::path& file);

// Exactly so many finite numbers, separated by spaces. Throws InputError at `node`.
std::vector<double> numbersIn(const XmlNode& node, std::string_view text, std::size_t count);
Vec3d vectorIn(const XmlNode& node, std::string_view text);

}  // namespace scanmill
