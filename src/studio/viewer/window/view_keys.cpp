#include "viewer/window/view_keys.h"

#include <array>

#include "viewer/window/session.h"

namespace scanmill {

namespace {

struct KeyRow {
  std::string_view key;
  KeyAction action;
};

constexpr KeyRow kKeys[] = {
    {"c", KeyAction::NextColor},
    {"C", KeyAction::PreviousColor},
    {"[", KeyAction::LowerHighEnd},
    {"]", KeyAction::RaiseHighEnd},
    {"{", KeyAction::LowerLowEnd},
    {"}", KeyAction::RaiseLowEnd},
    {"\\", KeyAction::AutomaticScale},
    {"+", KeyAction::LargerPoints},
    {"=", KeyAction::LargerPoints},
    {"-", KeyAction::SmallerPoints},
    {"b", KeyAction::NextBackground},
    {"a", KeyAction::ToggleAxes},
    {"A", KeyAction::ShowAllClasses},
    {"x", KeyAction::InstanceAlone},
    {"r", KeyAction::ToggleRangeRings},
    {"m", KeyAction::ToggleMesh},
    {"O", KeyAction::ToggleBoxes},
    {"t", KeyAction::ToggleTrajectory},
    {"e", KeyAction::ToggleDepthEdges},
    {"k", KeyAction::ToggleLegends},
    {"o", KeyAction::ToggleProjection},
    {"F1", KeyAction::ChaseView},
    {"F2", KeyAction::DriverView},
    {"F3", KeyAction::AboveView},
    {"v", KeyAction::NextPreset},
    {"f", KeyAction::TurnAbout},
    {"Home", KeyAction::ResetView},
    {"Right", KeyAction::NextFrame},
    {".", KeyAction::NextFrame},
    {"Left", KeyAction::PreviousFrame},
    {",", KeyAction::PreviousFrame},
    {"Page_Down", KeyAction::TenFramesOn},
    {"Page_Up", KeyAction::TenFramesBack},
    {"<", KeyAction::FirstFrame},
    {">", KeyAction::LastFrame},
    {"End", KeyAction::LastFrame},
    {" ", KeyAction::Play},
    {"(", KeyAction::Slower},
    {")", KeyAction::Faster},
    {"g", KeyAction::GoTo},
    {"l", KeyAction::ToggleOverlay},
    {"s", KeyAction::ToggleSplit},
    {"Tab", KeyAction::NextView},
    {"n", KeyAction::NextScan},
    {"w", KeyAction::ToggleWorld},
    {"d", KeyAction::Measure},
    {"i", KeyAction::ToggleRangeImage},
    {"I", KeyAction::ToggleStripOrder},
    {"P", KeyAction::SavePicture},
    {"h", KeyAction::ToggleHelp},
    {"?", KeyAction::ToggleHelp},
    {"Escape", KeyAction::Escape},
    {"q", KeyAction::Quit},
};

constexpr std::array<std::string_view, 10> kDigits{"1", "2", "3", "4", "5", "6", "7", "8", "9", "0"};

}  // namespace

std::optional<KeyMeaning> keyMeaning(std::string_view key, bool shift) {
  if (shift && key == "Left") return KeyMeaning{KeyAction::FirstFrame};
  if (shift && key == "Right") return KeyMeaning{KeyAction::LastFrame};
  for (const KeyRow& row : kKeys) {
    if (row.key == key) return KeyMeaning{row.action};
  }
  for (std::size_t i = 0; i < kDigits.size(); ++i) {
    if (kDigits[i] == key) return KeyMeaning{KeyAction::ColorByNumber, i};
  }
  return {};
}

std::vector<std::pair<std::string, std::string>> viewKeys() {
  std::string colors;
  for (std::size_t i = 0; i < kDigits.size(); ++i) colors += (i == 0 ? "" : ", ") + colorNames()[i];
  return {
      {"left drag", "turn"},
      {"right drag, shift + left drag", "move"},
      {"wheel", "nearer, farther"},
      {"click", "pin what lies there; in the legend: hide or show"},
      {"double click, shift + click in the legend", "show that alone"},
      {"Right, Left (. ,)", "next, previous frame"},
      {"Page_Down, Page_Up", "ten frames on, back"},
      {"< > (shift + Left, Right)", "first, last frame"},
      {"space", "play, pause"},
      {"( )", "play slower, faster"},
      {"g", "go to a sample by its key or index"},
      {"c, C", "colour by the next, previous column"},
      {"1 2 3 4 5 6 7 8 9 0", "colour by " + colors},
      {"[ ]", "upper end of the scale: half, twice of it"},
      {"{ }", "lower end of the scale: lower, higher"},
      {"\\", "the scale that the values give"},
      {"A", "show all classes and instances"},
      {"x", "the instance that is pointed at alone, all again"},
      {"+ -", "larger, smaller points"},
      {"b", "background dark, grey, white"},
      {"a", "axes of the sensors: x red, y green, z blue"},
      {"r", "range rings on the ground"},
      {"t", "trajectory"},
      {"m", "mesh of the scene"},
      {"O", "boxes of objects, with class, id and visible share"},
      {"e", "dark depth edges"},
      {"k", "legends (what colours mean)"},
      {"o", "perspective, orthographic"},
      {"F1 F2 F3", "chase, driver's, from above"},
      {"v", "the next of these views"},
      {"f, double click", "look at what is pointed at, and turn about it"},
      {"Home", "the first view again"},
      {"n", "next scan of the sample"},
      {"l", "overlay: all scans of the sample in colours of their own"},
      {"s", "split: scans, or colours of one scan, side by side"},
      {"Tab", "the view that c acts on"},
      {"w", "stand in the world, follow the sensor"},
      {"i", "range image"},
      {"I", "range image: looking outward, as the sensor orders it"},
      {"d", "distance: between two clicks"},
      {"P", "save a picture"},
      {"h", "these keys; Up, Down or the wheel: more of them"},
      {"Escape", "close what is open: help, distance, pin, instance alone"},
      {"q", "quit"},
  };
}

}  // namespace scanmill
