#pragma once

// Reads settings: methods with their options. Studies compare the settings of a list.
//
//   - ray_tracing
//   - {depth_camera: {resolution: [512, 1024, 2048], sampling: [plane, nearest]}}
//
// If the value of an option is a list, there is one setting per item; with several lists, one per combination of items.

#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"

namespace scanmill {

// A method with its options, as texts.
struct Setting {
  std::string name;    // name of the setting, such as "depth_camera resolution=512 sampling=nearest"; only the method's
                       // name if no options are given
  std::string method;  // the method's name in the table methods()
  std::string options;  // options as YAML text, such as "{resolution: 512, sampling: nearest}"; "{}": all defaults

  // Returns the argument of --set that selects the setting, such as "method={depth_camera: {resolution: 512}}".
  std::string assignment() const;
};

// A setting with the YAML values from which it was read. Messages take the file and the line from these values.
struct MethodSetting {
  Setting setting;
  MethodChoice choice;
};

// Returns a map for each combination of items of the map's lists, one item from each list. The item of the last list
// changes fastest. `what`: name of the map in messages. Throws InputError.
std::vector<Value> expandLists(const Value& options, const std::string& what);
// Returns the name of a setting, such as "depth_camera resolution=512". `name`: the method's name.
std::string settingName(const std::string& name, const Value& options);

// Reads a list of settings and checks their options. `what`: name of the list in messages. Throws InputError with file
// and line.
std::vector<MethodSetting> readSettings(const Value& list, const std::string& what);

}  // namespace scanmill
