#pragma once

// Methods with their options, as lists that studies and `method: auto` choose from.
//
//   - ray_tracing
//   - {depth_camera: {resolution: [512, 1024, 2048], sampling: [plane, nearest]}}
//
// A list as a value stands for a setting per item, two lists for all pairs.

#include <string>
#include <vector>

#include "pipeline/pipeline.h"

namespace scanmill {

// A setting as a pipeline would name it.
struct Setting {
  std::string name;     // "depth_camera resolution=512 sampling=nearest"; the method's name alone: its defaults
  std::string method;   // row of methods()
  std::string options;  // "{resolution: 512, sampling: nearest}"; "{}" where all are defaults

  // What --set takes to make a pipeline use it: "method={depth_camera: {resolution: 512}}".
  std::string assignment() const;
};

// With the values it came from, which know their places in files.
struct MethodSetting {
  Setting setting;
  MethodChoice choice;
};

// The same for a measurement: what an earlier run has kept would hide what building it takes, so a method that keeps
// something (MethodEntry::cacheOption) builds it anew, unless the options name a cache.
MethodChoice builtAnew(MethodChoice choice);

// "name" or {name: {options}}: a method, or an item of a list of settings, effects or formats; `what` in messages.
struct NamedOptions {
  std::string name;
  Location where;
  Value options;
};
NamedOptions readNamed(const Value& value, const std::string& what);
// One map per choice of items from the map's lists; the last list changes first.
std::vector<Value> expandLists(const Value& options, const std::string& what);
// "depth_camera resolution=512".
std::string settingName(const std::string& name, const Value& options);
// YAML on one line, "{resolution: 512}"; a value of the kind Null gives "{}".
std::string flowText(const Value& value);

// `what` names the list in messages. Every setting's options are checked. Throws InputError with the place.
std::vector<MethodSetting> readSettings(const Value& list, const std::string& what);

}  // namespace scanmill
