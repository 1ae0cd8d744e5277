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
  SelectBox,
  SelectLasso,
  ToggleRangeImage,
  ToggleStripOrder,
  SavePicture,
  ToggleHelp,
  Escape,
  Quit,
};

struct KeyMeaning {
  KeyAction action = KeyAction::Quit;
  std::size_t number = 0;  // of ColorByNumber: into colorNames()
};

// What a menu has, or, without a menu, a key alone.
struct ViewCommand {
  std::string_view menu;
  KeyMeaning meaning;
  std::string label;
  std::vector<std::string> keys;  // what they type: "c"; or their names: "Left"; "shift + Left"
};
// In the menus' order.
const std::vector<ViewCommand>& viewCommands();

// None for a key that does nothing.
std::optional<KeyMeaning> keyMeaning(std::string_view key, bool shift);

// "space", "F1 or v": as menus and help write them.
std::string keysText(const ViewCommand& command);

}  // namespace scanmill
