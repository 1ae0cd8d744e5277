#include "dataset/json_node.h"

#include <cmath>

namespace scanmill {

namespace {

Location placeOfByte(const std::string& text, std::size_t byte, const std::string& file) {
  const std::string_view before = std::string_view(text).substr(0, byte == 0 ? 0 : std::min(byte - 1, text.size()));
  const std::size_t lineStart = before.rfind('\n') + 1;  // if there is no line break, npos + 1 is 0
  return {file, static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1,
          static_cast<int>(before.size() - lineStart) + 1};
}

}  // namespace

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
