#pragma once

// What the viewer's keys mean.

#include <cstddef>
#include <optional>
#include <string_view>

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

// By X's name of the key's symbol; none for a key that does nothing.
std::optional<KeyMeaning> keyMeaning(std::string_view key, bool shift);

}  // namespace scanmill
