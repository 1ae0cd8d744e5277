#pragma once

// The viewer's commands: its menus, its keys and its help.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

enum class KeyAction {
  NextColor,
  PreviousColor,
  ColorByNumber,
  LowerHighEnd,
  RaiseHighEnd,
  LowerLowEnd,
  RaiseLowEnd,
  AutomaticScale,
  LargerPoints,
  SmallerPoints,
  NextBackground,
  ToggleAxes,
  ToggleRangeRings,
  ToggleMesh,
  ToggleBoxes,
  ToggleTrajectory,
  ToggleDepthEdges,
  ToggleLegends,
  ToggleProjection,
  ChaseView,
  DriverView,
  AboveView,
  NextPreset,
  TurnAbout,
  ResetView,
  NextFrame,
  PreviousFrame,
  TenFramesOn,
  TenFramesBack,
  FirstFrame,
  LastFrame,
  Play,
  Slower,
  Faster,
  GoTo,
  ToggleOverlay,
  ToggleSplit,
  NextView,
  NextScan,
  ToggleWorld,
  ShowAllClasses,
  InstanceAlone,
  Measure,
  ToggleRangeImage,
  SavePicture,
  ToggleHelp,
  Escape,
  Quit,
};

struct KeyMeaning {
  KeyAction action = KeyAction::Quit;
  std::size_t number = 0;  // for ColorByNumber: index into colorNames()
};

// A command in a menu, or, if `menu` is empty, of a key alone.
struct ViewCommand {
  std::string_view menu;
  KeyMeaning meaning;
  std::string label;
  std::vector<std::string> keys;  // the characters that they type: "c"; or their names: "Left"; "shift + Left"
};
// Returns all commands, in the order of the menus.
const std::vector<ViewCommand>& viewCommands();

// Returns the meaning of a key; none if the key does nothing.
std::optional<KeyMeaning> keyMeaning(std::string_view key, bool shift);

// Returns the command's keys as menus and help show them: "space", "F1 or v".
std::string keysText(const ViewCommand& command);

}  // namespace scanmill
