#pragma once

// Strict reading of maps: every key is asked for by name and type, and finish() refuses the ones nobody asked for.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// Closed interval; both ends must be finite or infinite, never NaN.
struct Range {
  double low = -INFINITY;
  double high = INFINITY;
};

// Typed reads of one value. All throw InputError with the value's place, what was expected and what was found.
double readNumber(const Value& value, std::string_view what, Range range = {});  // finite; 1e3, -.5; never hex or octal
std::int64_t readInteger(const Value& value, std::string_view what, std::int64_t low, std::int64_t high);
bool readBool(const Value& value, std::string_view what);  // true or false
std::string readText(const Value& value, std::string_view what);
Vec3d readVec3(const Value& value, std::string_view what);  // [x, y, z]
std::vector<double> readNumbers(const Value& value, std::string_view what, Range range = {});

// The name in `names` nearest to `word` by edit distance, or empty when none is near.
std::string nearest(std::string_view word, const std::vector<std::string>& names);
// " (did you mean 'x'?)" or " (known: a, b, c)".
std::string suggestion(std::string_view word, const std::vector<std::string>& names);

// Reads one map. Keeps a reference: the Value must outlive it.
//
//   Fields f(value, "sensor");
//   const double hz = f.number("rate_hz", {0.01, 1000}, 10.0);   // optional, with a default
//   const std::string name = f.text("name");                     // required
//   f.finish();                                                  // anything else is an error
class Fields {
 public:
  // `what` names the map in messages ("sensor", "effect range_noise"). Throws unless value is a map (Null counts as
  // {}).
  Fields(const Value& value, std::string what);

  bool has(std::string_view key) const;        // does not mark the key; an empty value counts as absent
  const Value* find(std::string_view key);     // marks the key as known; null where absent or empty
  const Value& require(std::string_view key);  // throws where absent; an empty value is given as it is
  const Location& where() const { return value_.where; }
  const Value& value() const { return value_; }

  double number(std::string_view key, Range range);
  double number(std::string_view key, Range range, double fallback);
  std::int64_t integer(std::string_view key, std::int64_t low, std::int64_t high);
  std::int64_t integer(std::string_view key, std::int64_t low, std::int64_t high, std::int64_t fallback);
  bool boolean(std::string_view key, bool fallback);
  std::string text(std::string_view key);
  std::string text(std::string_view key, std::string_view fallback);
  // One of `names`; an unknown word is refused with a suggestion.
  std::string choice(std::string_view key, const std::vector<std::string>& names, std::string_view fallback);
  Vec3d vec3(std::string_view key, const Vec3d& fallback);
  std::vector<double> numbers(std::string_view key, Range range);
  std::vector<std::string> texts(std::string_view key);  // a list of strings or one string; empty where absent
  // Relative paths are relative to the file that names them.
  std::filesystem::path path(std::string_view key);
  std::optional<std::filesystem::path> optionalPath(std::string_view key);

  // {position: [x, y, z], yaw_deg:, pitch_deg:, roll_deg:} or {position:, rotation: [w, x, y, z]}, read from this
  // map's own keys.
  Pose pose();

  // Throws for the first key that nobody asked for, with its place and the nearest known key.
  void finish() const;

 private:
  const Value& value_;
  std::string what_;
  std::vector<std::string> known_;
};

// Resolves `name` against the folder of the file that `where` is in.
std::filesystem::path resolvePath(const Location& where, const std::string& name);

}  // namespace scanmill
