#include "assets/worlds/xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <set>

#include "base/file.h"
#include "base/text_scan.h"
#include "config/text.h"

namespace scanmill {
namespace {

constexpr int kDeepestElement = 64;

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file.string()), bytes_(readFile(file)) {
    for (std::size_t i = 0; i < bytes_.size(); ++i) {
      if (bytes_[i] == '\n') lineEnds_.push_back(i);
    }
  }

  XmlNode read() const {
    pugi::xml_document document;
    const pugi::xml_parse_result result = document.load_buffer(bytes_.data(), bytes_.size());
    if (!result && bytes_.find("<%") != std::string::npos) {
      throw InputError(locationOf(result.offset), "is a template: expand it first, by `erb FILE.erb > FILE`");
    }
    if (!result) {
      throw InputError(locationOf(result.offset), "is not XML: {}", result.description());
    }
    const pugi::xml_node root = document.document_element();
    if (!root) throw InputError({file_}, "is not XML: it has no element");
    return convert(root, 0);
  }

 private:
  Location locationOf(std::ptrdiff_t offset) const {
    const auto line = std::lower_bound(lineEnds_.begin(), lineEnds_.end(), static_cast<std::size_t>(offset));
    return {file_, static_cast<int>(line - lineEnds_.begin()) + 1};
  }

  // Converts an element and its descendants. `depth`: the number of the element's ancestors.
  XmlNode convert(const pugi::xml_node& element, int depth) const {
    XmlNode node;
    node.where = locationOf(element.offset_debug());
    if (depth > kDeepestElement)
      throw InputError(node.where, "has elements that are nested more than {} levels deep", kDeepestElement);
    node.name = element.name();
    if (node.name == "xi:include") node.fail("names another file: expand it first, by `xmllint --xinclude FILE`");
    std::string text;  // comments may split the text into several pieces
    for (const pugi::xml_node& child : element.children()) {
      if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) text += child.value();
      if (child.type() == pugi::node_element) node.children.push_back(convert(child, depth + 1));
    }
    node.text = trimmed(text);
    for (const pugi::xml_attribute& a : element.attributes()) {
      node.attributes.emplace_back(a.name(), trimmed(a.value()));
    }
    return node;
  }

  std::string file_;
  std::string bytes_;
  std::vector<std::size_t> lineEnds_;
};

}  // namespace

const XmlNode* XmlNode::child(std::string_view childName) const {
  const auto found = std::ranges::find(children, childName, &XmlNode::name);
  return found == children.end() ? nullptr : &*found;
}

const std::string* XmlNode::attribute(std::string_view attribute) const {
  const auto found = std::ranges::find(attributes, attribute, &std::pair<std::string, std::string>::first);
  return found == attributes.end() ? nullptr : &found->second;
}

std::string XmlNode::attributeOr(std::string_view attribute, std::string_view fallback) const {
  const std::string* const found = this->attribute(attribute);
  return found == nullptr ? std::string(fallback) : *found;
}

std::string XmlNode::textOf(std::string_view childName, std::string_view fallback) const {
  const XmlNode* const found = child(childName);
  return found == nullptr ? std::string(fallback) : found->text;
}

XmlNode readXml(const std::filesystem::path& file) {
  return Reader(file).read();
}

std::vector<double> numbersIn(const XmlNode& node, std::string_view text, std::size_t count) {
  std::vector<double> numbers;
  for (const std::string_view word : wordsOf(text)) {
    double number = 0;
    if (!parseNumber(word, number) || !std::isfinite(number)) {
      node.fail("has {}, but must have a number here", quotedForMessage(word));
    }
    numbers.push_back(number);
  }
  if (numbers.size() != count) node.fail("has {} numbers, but must have {}", numbers.size(), count);
  return numbers;
}

void countMisplaced(const XmlNode& parent, std::span<const ElementPlace> places, LeftOut& leftOut) {
  std::set<const ElementPlace*> takenPlaces;
  for (const XmlNode& child : parent.children) {
    const auto names = [&](const ElementPlace& place) { return containsWord(place.names, child.name); };
    const auto allows = [&](const ElementPlace& place) {
      return names(place) && containsWord(place.parents, parent.name);
    };
    const auto place = std::ranges::find_if(places, allows);
    if (place == places.end()) {
      if (std::ranges::any_of(places, names)) {
        leftOut.add(fmt::format("misplaced <{}> in <{}>", child.name, parent.name));
      }
    } else if (!place->isMany && !takenPlaces.insert(&*place).second) {
      leftOut.add(fmt::format("second <{}> in <{}>", child.name, parent.name));
    }
  }
}

Vec3d vectorIn(const XmlNode& node, std::string_view text) {
  const std::vector<double> n = numbersIn(node, text, 3);
  return {n[0], n[1], n[2]};
}

}  // namespace scanmill
