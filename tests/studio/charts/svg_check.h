#pragma once

// Reads a chart back from its SVG.

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "base/vec.h"
#include "charts/svg_text.h"

namespace scanmill {

struct SvgElement {
  std::string tag;
  std::map<std::string, std::string> attributes;
  std::string text;                 // its own, entities resolved
  std::vector<std::size_t> inside;  // the elements around it, outermost first
};

// Fails the test where the text is not well-formed XML of the kind that a writer makes: no declarations, no comments.
inline std::vector<SvgElement> parseSvg(const std::string& svg) {
  std::vector<SvgElement> elements;
  std::vector<std::size_t> open;
  const auto fail = [&](const std::string& what, std::size_t at) {
    ADD_FAILURE() << what << " at " << at << ": " << svg.substr(at, 60);
    return elements;
  };
  const std::map<std::string, std::string> entities{
      {"amp", "&"}, {"lt", "<"}, {"gt", ">"}, {"quot", "\""}, {"#39", "'"}};
  const auto resolved = [&](const std::string& text, std::string& out) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != '&') {
        out += text[i];
        continue;
      }
      const std::size_t end = text.find(';', i);
      if (end == std::string::npos || !entities.contains(text.substr(i + 1, end - i - 1))) return false;
      out += entities.at(text.substr(i + 1, end - i - 1));
      i = end;
    }
    return true;
  };
  for (std::size_t i = 0; i < svg.size();) {
    if (svg[i] != '<') {
      const std::size_t end = std::min(svg.find('<', i), svg.size());
      const std::string text = svg.substr(i, end - i);
      if (open.empty() && text.find_first_not_of(" \n") != std::string::npos) return fail("text outside", i);
      if (!open.empty() && !resolved(text, elements[open.back()].text)) return fail("a bare &", i);
      i = end;
      continue;
    }
    const std::size_t end = svg.find('>', i);
    if (end == std::string::npos) return fail("an open tag", i);
    std::string tag = svg.substr(i + 1, end - i - 1);
    if (tag.starts_with("/")) {
      if (open.empty() || elements[open.back()].tag != tag.substr(1)) return fail("a foreign end", i);
      open.pop_back();
      i = end + 1;
      continue;
    }
    const bool closed = tag.ends_with("/");
    if (closed) tag.pop_back();
    SvgElement element;
    std::size_t at = std::min(tag.find(' '), tag.size());
    element.tag = tag.substr(0, at);
    element.inside = open;
    while (at < tag.size()) {
      at = tag.find_first_not_of(' ', at);
      if (at == std::string::npos) break;
      const std::size_t equals = tag.find("=\"", at);
      const std::size_t quote = equals == std::string::npos ? equals : tag.find('"', equals + 2);
      if (quote == std::string::npos) return fail("an attribute without a value", i);
      std::string value;
      if (!resolved(tag.substr(equals + 2, quote - equals - 2), value)) return fail("a bare &", i);
      if (!element.attributes.emplace(tag.substr(at, equals - at), value).second) return fail("an attribute twice", i);
      at = quote + 1;
    }
    elements.push_back(element);
    if (!closed) open.push_back(elements.size() - 1);
    i = end + 1;
  }
  if (!open.empty()) ADD_FAILURE() << "never closed: " << elements[open.back()].tag;
  return elements;
}

// A chart's own elements of a class; what the legend shows is left out.
inline std::vector<SvgElement> elementsOf(const std::string& svg, const std::string& kind) {
  std::vector<SvgElement> found;
  const std::vector<SvgElement> all = parseSvg(svg);
  for (const SvgElement& e : all) {
    const auto its = e.attributes.find("class");
    if (its == e.attributes.end() || (" " + its->second + " ").find(" " + kind + " ") == std::string::npos) continue;
    bool legend = false;
    for (const std::size_t around : e.inside) {
      const auto outer = all[around].attributes.find("class");
      legend |= outer != all[around].attributes.end() && outer->second == "legend";
    }
    if (!legend) found.push_back(e);
  }
  return found;
}

inline std::vector<std::string> textsOf(const std::string& svg, const std::string& kind) {
  std::vector<std::string> texts;
  for (const SvgElement& e : elementsOf(svg, kind)) texts.push_back(e.text);
  return texts;
}

inline double numberOf(const SvgElement& e, const std::string& name) {
  return std::stod(e.attributes.at(name));
}

// The centres of dots, in the order they are drawn.
inline std::vector<Vec2d> dotsOf(const std::string& svg) {
  std::vector<Vec2d> dots;
  for (const SvgElement& e : elementsOf(svg, "mark")) {
    const std::string& moved = e.attributes.at("transform");  // translate(1,2)
    const std::size_t comma = moved.find(',');
    dots.push_back({std::stod(moved.substr(10, comma - 10)), std::stod(moved.substr(comma + 1))});
  }
  return dots;
}

// Where the tick with this text is: x of ticks below, y of ticks beside the chart.
inline double tickPlace(const std::string& svg, const std::string& text, const std::string& anchor) {
  for (const SvgElement& e : elementsOf(svg, "tick")) {
    if (e.text != text || e.attributes.at("text-anchor") != anchor) continue;
    return anchor == "middle" ? numberOf(e, "x") : numberOf(e, "y") - 11.5 * 0.35;
  }
  ADD_FAILURE() << "no tick " << text;
  return 0;
}

struct LabelBox {
  double left, top, right, bottom;
  bool overlaps(const LabelBox& o) const {
    return left < o.right && o.left < right && top < o.bottom && o.top < bottom;
  }
};

inline std::vector<LabelBox> labelBoxes(const std::string& svg) {
  constexpr double kLabelFont = 11.5;
  std::vector<LabelBox> boxes;
  for (const SvgElement& e : elementsOf(svg, "label")) {
    const double width = svgTextWidth(e.text, kLabelFont, e.attributes.at("class").ends_with("strong"));
    const std::string& anchor = e.attributes.at("text-anchor");
    const double x = numberOf(e, "x"), y = numberOf(e, "y");
    const double left = anchor == "start" ? x : anchor == "end" ? x - width : x - width / 2;
    boxes.push_back({left, y - kLabelFont * 0.9, left + width, y + kLabelFont * 0.3});
  }
  return boxes;
}

}  // namespace scanmill
