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

// A setting in words.
struct Setting {
  std::string name;     // "depth_camera resolution=512 sampling=nearest"; of a method with all defaults its name alone
  std::string method;   // the name of its row of methods()
  std::string options;  // "{resolution: 512, sampling: nearest}"; "{}" where all are defaults

  // The argument of --set that makes a pipeline use it: "method={depth_camera: {resolution: 512}}".
  std::string assignment() const;
};

// A setting with the values that it was read from, which know their places in files.
struct MethodSetting {
  Setting setting;
  MethodChoice choice;
};

// One map for every choice of one item from each of the map's lists; the choice from the last list changes first.
// `what` names the map in messages. Throws InputError.
std::vector<Value> expandLists(const Value& options, const std::string& what);
// The name of a setting, "depth_camera resolution=512".
std::string settingName(const std::string& name, const Value& options);

// Reads a list of settings and checks the options of each. `what` names the list in messages. Throws InputError with
// the place.
std::vector<MethodSetting> readSettings(const Value& list, const std::string& what);

}  // namespace scanmill
