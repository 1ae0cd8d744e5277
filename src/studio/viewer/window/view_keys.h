#pragma once

// The viewer's commands: its menus, its keys and its help.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "viewer/window/view_options.h"

namespace scanmill {

enum class KeyAction {
  StepColor,      // number: 1 or -1
  ColorByNumber,  // number: index in colorNames()
  AutomaticScale,
  ResizePoints,  // number: pixels
  NextBackground,
  Switch,  // switches `option` on and off
  ToggleBoxes,
  ToggleProjection,
  PresetView,  // number: a value of View
  TurnAbout,
  ResetView,
  StepFrames,  // number: how many
  FirstFrame,
  LastFrame,
  Play,
  GoTo,
  ToggleOverlay,
  ToggleSplit,
  NextView,
  NextScan,
  ToggleWorld,
  ShowAllClasses,
  InstanceAlone,
  Measure,
  SavePicture,
  ToggleHelp,
  Escape,
  Quit,
};

struct KeyMeaning {
  KeyAction action = KeyAction::Quit;
  int number = 0;
  bool ViewOptions::*option = nullptr;
  bool operator==(const KeyMeaning&) const = default;
};

// A command. If `menu` is empty, the command is in no menu and has only keys.
struct ViewCommand {
  std::string_view menu;
  KeyMeaning meaning;
  std::string label;
  std::vector<std::string> keys;  // typed characters, such as "c", or names of keys, such as "Left"
  // Why the command does nothing for a scene without scans, which has triangles, but no points or frames; empty: it
  // works.
  std::string_view lacksInScene{};
};
// Returns all commands, in the order of the menus.
const std::vector<ViewCommand>& viewCommands();

// Returns the meaning of a key; nothing if the key has no function.
std::optional<KeyMeaning> keyMeaning(std::string_view key);

// Returns the command's keys as text for menus and help, such as "space" or "h or ?".
std::string keysText(const ViewCommand& command);

// Returns pairs of keys or gestures and their functions, for the help and the documentation.
std::vector<std::pair<std::string, std::string>> viewKeys();

}  // namespace scanmill
