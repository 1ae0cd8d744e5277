#pragma once

// Settings: methods with their options, in lists that studies compare and that `method: auto` chooses from.
//
//   - ray_tracing
//   - {depth_camera: {resolution: [512, 1024, 2048], sampling: [plane, nearest]}}
//
// A list as a value stands for one setting per item; two lists stand for all pairs of their items.

#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"

namespace scanmill {

// A setting as text.
struct Setting {
  std::string name;     // "depth_camera resolution=512 sampling=nearest"; with all defaults only the method's name
  std::string method;   // the name of its row of methods()
  std::string options;  // "{resolution: 512, sampling: nearest}"; "{}": all defaults

  // Returns the argument of --set that makes a pipeline use the setting: "method={depth_camera: {resolution: 512}}".
  std::string assignment() const;
};

// A setting with the values from which it was read; these know their places in files.
struct MethodSetting {
  Setting setting;
  MethodChoice choice;
};

// Returns a map for each combination of one item from each of the map's lists; the item of the last list varies
// fastest. `what` names the map in messages. Throws InputError.
std::vector<Value> expandLists(const Value& options, const std::string& what);
// Returns the name of a setting, "depth_camera resolution=512".
std::string settingName(const std::string& name, const Value& options);

// Reads a list of settings and checks the options of each. `what` names the list in messages. Throws InputError with
// the place.
std::vector<MethodSetting> readSettings(const Value& list, const std::string& what);

}  // namespace scanmill
