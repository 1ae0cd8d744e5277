#include "dataset/json_text.h"

#include <cmath>

namespace scanmill {

namespace {

constexpr std::size_t kLineWidth = 120;

// Returns the text of a list (`brackets`: "[]") or an object ("{}") with these items. Each item has a line of its own
// if an item has line breaks, or if one line would be too long and `mayBeLong` is false. `indent`: number of spaces
// before the closing bracket.
std::string joined(const std::vector<std::string>& items, const char* brackets, bool mayBeLong, std::size_t indent) {
  std::size_t width = indent + 2;      // width of the text if it is on one line
  std::size_t bytes = 2 * indent + 8;  // upper bound of the text's bytes
  bool hasBreaks = false;
  for (const std::string& item : items) {
    hasBreaks = hasBreaks || item.find('\n') != std::string::npos;
    width += item.size() + 2;
    bytes += item.size() + indent + 3;
  }
  const bool onOneLine = !hasBreaks && (width <= kLineWidth || mayBeLong);
  const std::string lineBreak = "\n" + std::string(indent, ' ');  // followed by one more space before an item
  const std::string separator = onOneLine ? ", " : "," + lineBreak + " ";
  std::string text;
  text.reserve(bytes);
  text += brackets[0];
  if (!onOneLine) text += lineBreak + " ";
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += separator;
    text += items[i];
  }
  if (!onOneLine) text += lineBreak;
  text += brackets[1];
  return text;
}

// Returns the line and column of a byte of the text. `byte`: from 1, as in nlohmann::json::parse_error.
Location placeOfByte(const std::string& text, std::size_t byte, const std::string& file) {
  const std::string_view before = std::string_view(text).substr(0, byte == 0 ? 0 : std::min(byte - 1, text.size()));
  const std::size_t lineStart = before.rfind('\n') + 1;  // if there is no line break, npos + 1 is 0
  return {file, static_cast<int>(std::ranges::count(before, '\n')) + 1,
          static_cast<int>(before.size() - lineStart) + 1};
}

}  // namespace

std::string scalarText(const OrderedJson& value) {
  // A text that is not UTF-8, such as a comment in a pipeline, must not prevent the manifest from being written.
  return value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

std::string layOut(const OrderedJson& value, std::size_t indent) {
  if (!value.is_structured()) return scalarText(value);
  std::vector<std::string> items;
  for (const auto& [key, child] : value.items()) {
    items.push_back(value.is_object() ? scalarText(key) + ": " : std::string());
    items.back() += layOut(child, indent + 1);
  }
  const bool isNumberList =
      value.is_array() && std::ranges::all_of(value, [](const OrderedJson& item) { return item.is_number(); });
  return joined(items, value.is_object() ? "{}" : "[]", isNumberList, indent);
}

std::string layOutList(const std::vector<std::string>& items, std::size_t indent) {
  return joined(items, "[]", false, indent);
}

double finite(double value, std::string_view what) {
  if (!std::isfinite(value)) throw Error("{} is {}, which a manifest cannot store", what, value);
  return value;
}

OrderedJson finiteList(const std::vector<double>& values, std::string_view what) {
  OrderedJson list = OrderedJson::array();
  for (const double value : values) list.push_back(finite(value, what));
  return list;
}

OrderedJson poseJson(const Pose& pose, std::string_view what) {
  const Quat& q = pose.rotation;
  const Vec3d& t = pose.translation;
  return {{"rotation", finiteList({q.w, q.x, q.y, q.z}, what)}, {"translation", finiteList({t.x, t.y, t.z}, what)}};
}

const SemanticClass& requireClass(std::uint16_t id, const std::string& key, const Ontology& ontology) {
  const SemanticClass* const semantic = ontology.find(id);
  if (semantic == nullptr) throw Error("{}: class {} is not in ontology '{}'", key, id, ontology.name);
  return *semantic;
}

Json parseJson(const std::string& text, const std::string& file) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    // The message begins "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while ..."
    const std::string_view what = error.what();
    const std::size_t colon = what.find(": ");
    throw InputError(placeOfByte(text, error.byte, file), "is not complete JSON: {}",
                     colon == std::string_view::npos ? what : what.substr(colon + 2));
  } catch (const Json::exception& error) {
    throw InputError({file}, "is not valid JSON: {}", reasonOf(error));
  }
}

Pose poseOf(const JsonNode& node) {
  node.keys({"rotation", "translation"});
  const std::vector<double> q = node["rotation"].numbers(4);
  const std::vector<double> t = node["translation"].numbers(3);
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(norm - 1) < 1e-6)) node["rotation"].fail("is not a unit quaternion (its norm is {})", norm);
  return {{q[0], q[1], q[2], q[3]}, {t[0], t[1], t[2]}};
}

}  // namespace scanmill
