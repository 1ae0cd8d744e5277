#pragma once

// Writes JSON as text. Keys keep their order, and numbers read back to the same bits. The same values therefore always
// give the same bytes.

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/vec.h"
#include "config/fields.h"
#include "dataset/manifest.h"
#include "scene/ontology.h"

namespace scanmill {

using OrderedJson = nlohmann::ordered_json;

// Returns the text of a single value (no list or map), without line breaks.
std::string scalarText(const OrderedJson& value);

// Returns the text of a value of any kind. Values that fit into a line, and all lists of numbers, are written on one
// line; other values are broken into lines, indented by one space per level.
std::string layOut(const OrderedJson& value, std::size_t indent = 0);
// Returns the text of a list. `items`: the texts of the items, laid out with `indent` + 1.
std::string layOutList(const std::vector<std::string>& items, std::size_t indent);

// Return a value or a list as JSON. Throw an Error that names `what` for infinities and NaN, which JSON does not have.
double finite(double value, std::string_view what);
OrderedJson finiteList(const std::vector<double>& values, std::string_view what);

OrderedJson poseJson(const Pose& pose, std::string_view what);
// Returns the class with this id. Throws an Error that begins with `key` if the ontology does not have it.
const SemanticClass& requireClass(std::uint16_t id, const std::string& key, const Ontology& ontology);
OrderedJson ontologyJson(const Ontology& ontology);

using Json = nlohmann::json;

// Parses a JSON text. Throws InputError with file, line and column.
Json parseJson(const std::string& text, const std::string& file);

// A JSON value and its place in the document. The node refers to the parsed document and to the file's name, both of
// which must outlive it.
class JsonNode {
 public:
  JsonNode(const Json& value, std::string path, const std::string& file)
      : value_(value), path_(std::move(path)), file_(file) {}

  // Throws an InputError with the file, the node's place in it, and the reason.
  template <class... Values>
  [[noreturn]] void fail(fmt::format_string<Values...> reason, Values&&... values) const {
    throw InputError({file_}, "{}: {}", path_.empty() ? "/" : path_,
                     fmt::format(reason, std::forward<Values>(values)...));
  }

  // Throws InputError unless the node is a map with all keys in `required` and other keys only from `optional`.
  const JsonNode& keys(std::span<const std::string_view> required, std::span<const std::string_view> optional) const {
    expect(value_.is_object(), "a map");
    for (const auto& entry : value_.items()) {  // checks unknown keys first, since a missing key may only be misspelt
      const auto isEntry = [&](std::string_view key) { return key == entry.key(); };
      if (std::ranges::any_of(required, isEntry) || std::ranges::any_of(optional, isEntry)) continue;
      std::vector<std::string> allowed(required.begin(), required.end());
      allowed.insert(allowed.end(), optional.begin(), optional.end());
      fail("key '{}' is unknown{}", entry.key(), suggestion(entry.key(), allowed));
    }
    for (const std::string_view key : required) {
      if (!value_.contains(key)) fail("key '{}' is missing", key);
    }
    return *this;
  }
  const JsonNode& keys(std::initializer_list<std::string_view> required,
                       std::initializer_list<std::string_view> optional = {}) const {
    return keys(std::span(required.begin(), required.size()), std::span(optional.begin(), optional.size()));
  }

  bool isNull() const { return value_.is_null(); }
  bool isText() const { return value_.is_string(); }
  bool has(std::string_view key) const { return value_.is_object() && value_.contains(key); }
  JsonNode operator[](const std::string& key) const { return {value_.at(key), path_ + "/" + key, file_}; }
  JsonNode item(std::size_t i) const { return {value_.at(i), fmt::format("{}/{}", path_, i), file_}; }
  std::string dump() const { return value_.dump(); }

  template <class Visit>
  void forEach(const Visit& visit) const {
    expect(value_.is_array(), "a list");
    for (std::size_t i = 0; i < value_.size(); ++i) visit(item(i));
  }
  template <class Visit>
  void forEachEntry(const Visit& visit) const {
    expect(value_.is_object(), "a map");
    for (const auto& entry : value_.items()) visit(entry.key(), (*this)[entry.key()]);
  }

  std::string text() const {
    expect(value_.is_string(), "text");
    return value_.get<std::string>();
  }
  bool boolean() const {
    expect(value_.is_boolean(), "true or false");
    return value_.get<bool>();
  }
  double number(double low = -std::numeric_limits<double>::max(),
                double high = std::numeric_limits<double>::max()) const {
    expect(value_.is_number(), "a number");
    const double number = value_.get<double>();
    if (!(number >= low && number <= high)) fail("{} is not within {} to {}", number, low, high);
    return number;
  }
  template <class Integer>
  Integer integer(std::uint64_t low = 0, std::uint64_t high = std::numeric_limits<Integer>::max()) const {
    expect(value_.is_number_unsigned(), "a whole number of at least 0");
    const std::uint64_t number = value_.get<std::uint64_t>();
    if (number < low || number > high) fail("{} is not within {} to {}", number, low, high);
    return static_cast<Integer>(number);
  }
  // Returns a finite number as text. Reading this text gives the same number.
  std::string numberText() const {
    number();
    return value_.dump();
  }
  // Throws InputError unless the node is a hash of this number of digits. `kind`: what the message calls it.
  void hash(std::string_view kind, std::size_t digits) const {
    const std::string hash = text();
    if (hash.size() != digits || hash.find_first_not_of("0123456789abcdef") != std::string::npos) {
      fail("is not {} ({} hexadecimal digits in lower case)", kind, digits);
    }
  }
  std::vector<double> numbers(std::size_t count) const {
    std::vector<double> list;
    forEach([&](const JsonNode& item) { list.push_back(item.number()); });
    if (list.size() != count) fail("has {} numbers, but must have {}", list.size(), count);
    return list;
  }

 private:
  void expect(bool hasType, std::string_view what) const {
    if (!hasType) fail("is {}, but must be {}", value_.type_name(), what);
  }

  const Json& value_;
  std::string path_;
  const std::string& file_;
};

// Reads {"rotation": [w, x, y, z], "translation": [x, y, z]}. Throws InputError unless the quaternion is a unit one.
Pose poseOf(const JsonNode& node);

}  // namespace scanmill
