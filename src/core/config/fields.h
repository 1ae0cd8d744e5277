#pragma once

// Strict reading of maps: every key is read by its name and type, and finish() refuses keys that were never read. This
// header is installed because formats/format.h includes it.
//
//   const Value file = parseYaml("name: top", "sensor.yaml");
//   Fields fields(file, "sensor");
//   const double hz = fields.number("rate_hz", {0.01, 1000}, 10.0);  // optional, with a default
//   const std::string name = fields.text("name");                    // required
//   fields.finish();                                                 // any other key is an error

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// A closed interval. Either end may be infinite, but not NaN.
struct Range {
  double low = -INFINITY;
  double high = INFINITY;
  bool contains(double value) const { return low <= value && value <= high; }
  bool operator==(const Range&) const = default;
};

// Each of these functions reads a value as one type. It throws an InputError that states the place of the value, what
// was expected and what was found. `what` names the value in the message.
double readNumber(const Value& value, std::string_view what, Range range = {});  // finite; decimal, such as 1e3 or -.5
std::int64_t readInteger(const Value& value, std::string_view what, std::int64_t low, std::int64_t high);
bool readBool(const Value& value, std::string_view what);  // only `true` or `false`
std::string readText(const Value& value, std::string_view what);
Vec3d readVec3(const Value& value, std::string_view what);                      // [x, y, z]
const std::vector<Value>& readList(const Value& value, std::string_view what);  // a list with at least one item
// An integer of a list, with its place in the file. In a list, "..." stands for all integers between its two
// neighbours, as in [1, ..., 20].
struct PlacedInteger {
  std::int64_t value = 0;
  Location where;
};
std::vector<PlacedInteger> readIntegers(const Value& list, std::string_view what, std::int64_t low, std::int64_t high);
std::vector<double> readNumbers(const Value& value, std::string_view what, Range range = {});

struct NamedOptions {
  std::string name;
  Location where;
  Value options;  // a value of the kind Null if only a name is given
};

// Reads an item that is a name with options, such as a method, an effect or a format: "name" or {name: {options}}.
// `what` describes the item in messages, such as "an effect". Throws InputError.
NamedOptions readNamed(const Value& value, const std::string& what);

// Returns the name in `names` that is nearest to `word` by edit distance; empty if none is near.
std::string nearest(std::string_view word, const std::vector<std::string>& names);
// Returns the hint for an unknown word: " (did you mean 'x'?)" if a name is near, else " (known: a, b, c)".
std::string suggestion(std::string_view word, const std::vector<std::string>& names);

// Returns the names of `entries`, in their order.
template <class Entries>
std::vector<std::string> namesOf(const Entries& entries) {
  std::vector<std::string> names;
  names.reserve(std::size(entries));
  for (const auto& entry : entries) names.emplace_back(entry.name);
  return names;
}

// Returns the entry called `name`. If there is none, throws an InputError, in which `kind` says what the entries are,
// such as "format".
template <class Entries>
const auto& requireNamed(const Entries& entries, std::string_view kind, std::string_view name,
                         const Location& where = {}) {
  for (const auto& entry : entries) {
    if (entry.name == name) return entry;
  }
  throw InputError(where, "unknown {} '{}'{}", kind, name, suggestion(name, namesOf(entries)));
}

// Reads one map. Keeps a reference to the Value, which must outlive this object.
class Fields {
 public:
  // `what` names the map in messages ("sensor", "effect range_noise"). Throws an InputError unless `value` is a map; an
  // empty value counts as an empty map.
  Fields(const Value& value, std::string what);

  // Each of these functions marks the key as known, so that finish() accepts it.
  bool has(std::string_view key) const { return find(key) != nullptr; }  // true if the key has a non-empty value
  const Value* find(std::string_view key) const;                         // null if absent or empty
  const Value& require(std::string_view key);  // throws if absent; an empty value (Null) is returned
  const Location& where() const { return value_.where; }
  const Value& value() const { return value_; }

  // Each of these functions returns the value of a key. If the key is absent or empty, the function returns `fallback`;
  // without a fallback it throws InputError.
  double number(std::string_view key, Range range, std::optional<double> fallback = {});
  std::int64_t integer(std::string_view key, std::int64_t low, std::int64_t high,
                       std::optional<std::int64_t> fallback = {});
  bool boolean(std::string_view key, bool fallback);
  std::string text(std::string_view key, std::optional<std::string_view> fallback = {});
  // Returns one of `names`; refuses an unknown word with a suggestion.
  std::string choice(std::string_view key, const std::vector<std::string>& names, std::string_view fallback);
  Vec3d vec3(std::string_view key, const Vec3d& fallback);
  std::vector<double> numbers(std::string_view key, Range range);
  // Returns the interval [least, most], whose ends lie in `limits`; nullopt if the key is absent.
  std::optional<Range> range(std::string_view key, Range limits);
  std::vector<std::string> texts(std::string_view key);  // a list of strings or one string; empty if absent
  // Returns a path. A relative path starts in the folder of the file in which the path is written.
  std::filesystem::path path(std::string_view key);
  std::optional<std::filesystem::path> optionalPath(std::string_view key);
  // Returns the path of a YAML file, given by its path or by the name of a file that comes with the program; see
  // resolveResource().
  std::filesystem::path resource(std::string_view key, const std::string& subfolder);
  std::optional<std::filesystem::path> optionalResource(std::string_view key, const std::string& subfolder);

  // Reads a pose from these keys of the map: {position: [x, y, z], yaw_deg:, pitch_deg:, roll_deg:} or {position:,
  // rotation: [w, x, y, z]}.
  Pose pose();

  // Marks keys as known, since they are read later or by other code. If also() and finish() are called before any key
  // is read, an unknown key is reported before a missing key.
  Fields& also(std::initializer_list<std::string_view> keys);
  // Marks the keys that a description explains: step_m and gain in "step_m: 1 m, what it is\ngain: 2, ...".
  Fields& alsoDescribed(std::string_view keys);

  // Throws an InputError for the first of the keys that the map has. `why` follows the key in the message, such as "is
  // for waypoints".
  void refuse(std::initializer_list<std::string_view> keys, std::string_view why);

  // Throws an InputError for the first unknown key of the map; the message names the key, its place and the most
  // similar known key.
  void finish() const;

 private:
  std::string pathText(std::string_view key);
  [[noreturn]] void refuseUnknown(std::string_view key, const Value& value, const std::string& advice) const;

  const Value& value_;
  std::string what_;
  mutable std::vector<std::string> known_;
};

// Returns the entry of `values` whose name is the value of the key. If the key is absent, returns the entry with the
// value `fallback`, which `values` must contain.
template <class T, std::size_t n>
const std::pair<const char*, T>& namedChoice(Fields& fields, std::string_view key,
                                             const std::pair<const char*, T> (&values)[n], T fallback) {
  std::vector<std::string> names;
  for (const auto& [name, value] : values) names.emplace_back(name);
  const std::string chosen = fields.choice(key, names, "");
  return *std::find_if(std::begin(values), std::end(values), [&](const auto& entry) {
    return chosen.empty() ? entry.second == fallback : chosen == entry.first;
  });
}

// Returns `name` as a path that starts in the folder of the file that contains `value`. A path given by --set starts in
// the folder of the file that --set changes or, if nothing exists there, in the current folder.
std::filesystem::path resolvePath(const Value& value, const std::string& name);

// Returns the path of the YAML file that `value` calls `name`: a path as for resolvePath(), or else a file in
// `subfolder` of resourceFolder() or in the parent of that subfolder (both os1_128 and sensors/os1_128.yaml are found
// in pipelines/sensors). `name` may lack the suffix .yaml. Throws an InputError that lists the places searched and the
// nearest existing file.
std::filesystem::path resolveResource(const Value& value, const std::string& name, const std::string& subfolder);

// Whether the height may change along a path.
enum class Climbs { Yes, No };

// Reads [[x, y, z], ...], at least two points, in metres. Throws an InputError with the place of a point that repeats
// the point before it, of a segment that is too steep to have a heading, or of a turn straight back. If the path may
// not climb, all points get the height of the first point.
std::vector<Vec3d> readWaypoints(const Value& value, Climbs climbs = Climbs::Yes);

// Returns `position` (m). Throws InputError if a coordinate is so large that doubles are not exact enough.
Vec3d checkedPosition(const Vec3d& position, const Location& where);

}  // namespace scanmill
