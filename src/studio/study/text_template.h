#pragma once

// Texts with places to fill in, in the language Mustache (mustache.github.io): {{name}} is a value of a JSON object,
// {{#name}}...{{/name}} is written for each item of a list, or once if the value is not empty, and
// {{^name}}...{{/name}} if it is empty. A colon precedes the format of a number:
//
//   {{scan_s:s}}             2.9 ms; also m, bytes, amount (45.3 M), share (98.4 %), factor (2.1), count (1,234,567),
//                            mm (12.34, without the unit) and digits (three significant ones, 0.0123)
//   {{lost/beams:share}}     the ratio of two values, as a share
//   {{size:.2f}}             any format of the library fmt
//   {{size:unit}}            12.3 mm, if the value `unit` is "mm"
//   {{scans:plural=scan}}    1 scan, 2 scans
//   {{setting:words}}        depth camera, from depth_camera
//   {{names:join}}           a, b, c
//   {{#names:any}}           once, if there are names
//
// Values that are null, empty or not finite count as empty.

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "dataset/json_node.h"

namespace scanmill {

// Escapes a value that is filled in; values in triple braces are not escaped.
using TextEscape = std::function<std::string(const std::string&)>;
// {{#name}}text{{/name}}: given the text, returns the template that replaces it.
using TemplateMacros = std::map<std::string, std::function<std::string(const std::string& text)>>;

// Returns the filled template. Throws Error if the template is wrong, which is an error of this program.
std::string fillTemplate(const std::string& text, const Json& values, const TextEscape& escape = {},
                         const TemplateMacros& macros = {});

}  // namespace scanmill
