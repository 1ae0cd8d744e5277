#include "dataset/json_text.h"

#include <cmath>

namespace scanmill {

namespace {

constexpr std::size_t kLineWidth = 120;

bool isNumberList(const OrderedJson& value) {
  return value.is_array() && std::ranges::all_of(value, [](const OrderedJson& v) { return v.is_number(); });
}

// Joins the texts of the items of a list or an object, between brackets.
std::string joined(const std::vector<std::string>& parts, const char* brackets, bool oneLine, std::size_t indent) {
  std::size_t width = indent + 2;
  std::size_t bytes = 2 * indent + 8;
  bool flat = true;
  for (const std::string& part : parts) {
    flat = flat && part.find('\n') == std::string::npos;
    width += part.size() + 2;
    bytes += part.size() + indent + 3;
  }
  flat = flat && (width <= kLineWidth || oneLine);
  const std::string separator = flat ? ", " : ",\n" + std::string(indent + 1, ' ');
  std::string text;
  text.reserve(bytes);
  text += brackets[0];
  if (!flat) text += "\n" + std::string(indent + 1, ' ');
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) text += separator;
    text += parts[i];
  }
  if (!flat) text += "\n" + std::string(indent, ' ');
  text += brackets[1];
  return text;
}

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
  std::vector<std::string> parts;
  for (const auto& [key, child] : value.items()) {
    std::string part = value.is_object() ? scalarText(key) + ": " : std::string();
    part += layOut(child, indent + 1);
    parts.push_back(std::move(part));
  }
  return joined(parts, value.is_object() ? "{}" : "[]", isNumberList(value), indent);
}

std::string layOutList(const std::vector<std::string>& items, std::size_t indent) {
  return joined(items, "[]", false, indent);
}

double finite(double value, std::string_view what) {
  if (!std::isfinite(value)) throw Error(fmt::format("{} is {}, which a manifest cannot store", what, value));
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
  const SemanticClass* const known = ontology.find(id);
  if (known == nullptr) throw Error(fmt::format("{}: class {} is not in ontology '{}'", key, id, ontology.name));
  return *known;
}

Json parseJson(const std::string& text, const std::string& file) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    // The message begins "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while ..."
    const std::string_view what = error.what();
    const std::size_t colon = what.find(": ");
    throw InputError(
        placeOfByte(text, error.byte, file),
        fmt::format("is not complete JSON: {}", colon == std::string_view::npos ? what : what.substr(colon + 2)));
  } catch (const Json::exception& error) {
    throw InputError({file}, fmt::format("is not valid JSON: {}", reasonOf(error)));
  }
}

Pose poseOf(const JsonNode& node) {
  node.keys({"rotation", "translation"});
  const std::vector<double> q = node["rotation"].numbers(4);
  const std::vector<double> t = node["translation"].numbers(3);
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(norm - 1) < 1e-6))
    node["rotation"].fail(fmt::format("is not a unit quaternion (its norm is {})", norm));
  return {{q[0], q[1], q[2], q[3]}, {t[0], t[1], t[2]}};
}

}  // namespace scanmill
