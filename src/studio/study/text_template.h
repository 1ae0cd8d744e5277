#pragma once

// Texts with places to fill in, in the language Mustache (mustache.github.io): {{name}} is a value of some JSON,
// {{#name}}...{{/name}} stands for each item of a list, or where there is something, {{^name}}...{{/name}} where there
// is nothing. Numbers have a format, behind a colon:
//
//   {{scan_s:s}}             2.9 ms; also m, bytes, amount (45.3 M), share (98.4 %), factor (2.1), count (1,234,567),
//                            mm (12.34, without the unit) and digits (three of them, 0.0123)
//   {{lost/beams:share}}     the share of two values
//   {{size:.2f}}             any format of fmt's
//   {{size:unit}}            12.3 mm, where the value `unit` is "mm"
//   {{scans:plural=scan}}    1 scan, 2 scans
//   {{setting:words}}        depth camera, of depth_camera
//   {{names:join}}           a, b, c
//   {{#names:any}}           once, where there are names
//
// What is null, empty or not finite is nothing.

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "dataset/json_node.h"

namespace scanmill {

// What changes a value that is filled in; values in triple braces stay as they are.
using TextEscape = std::function<std::string(const std::string&)>;
// {{#name}}text{{/name}}: writes the template that stands in place of the text.
using TemplateMacros = std::map<std::string, std::function<std::string(const std::string& text)>>;

// Throws Error where the template is wrong, which is a mistake of this program.
std::string fillTemplate(const std::string& text, const Json& values, const TextEscape& escape = {},
                         const TemplateMacros& macros = {});

}  // namespace scanmill
