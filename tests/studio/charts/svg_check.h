#pragma once

// Reads a chart back from its SVG.

#include <expat.h>

#include <map>
#include <memory>
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

// Fails the test where the text is not well-formed XML.
inline std::vector<SvgElement> parseSvg(const std::string& svg) {
  struct Reading {
    std::vector<SvgElement> elements;
    std::vector<std::size_t> open;
  } reading;
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(XML_ParserCreate("UTF-8"), XML_ParserFree);
  XML_SetUserData(parser.get(), &reading);
  XML_SetElementHandler(
      parser.get(),
      [](void* data, const char* tag, const char** attributes) {
        Reading& read = *static_cast<Reading*>(data);
        SvgElement element{tag, {}, {}, read.open};
        for (; *attributes != nullptr; attributes += 2) element.attributes[attributes[0]] = attributes[1];
        read.open.push_back(read.elements.size());
        read.elements.push_back(element);
      },
      [](void* data, const char*) { static_cast<Reading*>(data)->open.pop_back(); });
  XML_SetCharacterDataHandler(parser.get(), [](void* data, const char* text, int size) {
    Reading& read = *static_cast<Reading*>(data);
    read.elements[read.open.back()].text.append(text, static_cast<std::size_t>(size));
  });
  EXPECT_EQ(XML_Parse(parser.get(), svg.data(), static_cast<int>(svg.size()), XML_TRUE), XML_STATUS_OK)
      << XML_ErrorString(XML_GetErrorCode(parser.get())) << " in line " << XML_GetCurrentLineNumber(parser.get());
  return reading.elements;
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
    const double width = svgTextWidth(
        e.text, kLabelFont, e.attributes.at("class").ends_with("strong") ? FontWeight::Bold : FontWeight::Normal);
    const std::string& anchor = e.attributes.at("text-anchor");
    const double x = numberOf(e, "x"), y = numberOf(e, "y");
    const double left = anchor == "start" ? x : anchor == "end" ? x - width : x - width / 2;
    boxes.push_back({left, y - kLabelFont * 0.9, left + width, y + kLabelFont * 0.3});
  }
  return boxes;
}

}  // namespace scanmill
