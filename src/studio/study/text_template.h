#pragma once

// Fills text templates in the language Mustache (mustache.github.io) with values of a JSON object. {{name}} is replaced
// by a value. {{#name}}...{{/name}} is repeated for each item of a list, or written once if the value is not empty;
// {{^name}}...{{/name}} is written if the value is empty. The format of a number follows a colon:
//
//   {{scan_s:s}}             2.9 ms; also m, bytes, amount (45.3 M), share (98.4 %), factor (2.1), count (1,234,567)
//   {{lost/beams:share}}     the ratio of two values, in per cent
//   {{size:.2f}}             any format of the library fmt
//   {{size:unit}}            12.3 mm, if the value `unit` is "mm"
//   {{scans:plural=scan}}    1 scan, 2 scans
//   {{names:join}}           a, b, c
//   {{#names:any}}           written once if the list is not empty
//
// Null, empty texts and lists, and numbers that are not finite count as empty.

#include <functional>
#include <map>
#include <string>

#include "dataset/json_text.h"

namespace scanmill {

// Escapes a value before it is inserted; not called for values in triple braces.
using TextEscape = std::function<std::string(const std::string&)>;
// Functions by name. {{#name}}text{{/name}} calls the function `name` with the text, and is replaced by the
// template that the function returns.
using TemplateMacros = std::map<std::string, std::function<std::string(const std::string& text)>>;

// Returns the filled template. Without `escape`, inserts values as they are. Throws Error if the template is invalid.
std::string fillTemplate(const std::string& text, const Json& values, const TextEscape& escape = {},
                         const TemplateMacros& macros = {});

}  // namespace scanmill
