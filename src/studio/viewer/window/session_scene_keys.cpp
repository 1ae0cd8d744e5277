// States which keys do nothing if a scene is shown without scans: it has triangles, but neither points nor frames.

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "viewer/window/session_state.h"

namespace scanmill {

std::string ViewSession::State::sceneLacks(const ColorBy& by) const {
  if (std::find(kMeshColorNames.begin(), kMeshColorNames.end(), by.name()) != kMeshColorNames.end()) return {};
  return fmt::format("a scene has no {}: it is coloured by {}", by.name(), fmt::join(kMeshColorNames, ", "));
}

std::string ViewSession::State::sceneLacks(const KeyMeaning& meaning) const {
  switch (meaning.action) {
    case KeyAction::ColorByNumber:
      return sceneLacks(ColorBy(colorNames()[meaning.number]));
    case KeyAction::LargerPoints:
    case KeyAction::SmallerPoints:
      return "a scene has no points";
    case KeyAction::ToggleRangeRings:
      return "a scene has no sensor to draw range rings about";
    case KeyAction::ToggleTrajectory:
      return "a scene has no trajectory: a dataset of it has";
    case KeyAction::ToggleBoxes:
      return "a scene has no list of objects: a dataset of it may have";
    case KeyAction::ToggleMesh:
      return "the scene's mesh is all that there is";
    case KeyAction::NextFrame:
    case KeyAction::PreviousFrame:
    case KeyAction::TenFramesOn:
    case KeyAction::TenFramesBack:
    case KeyAction::FirstFrame:
    case KeyAction::LastFrame:
    case KeyAction::Play:
    case KeyAction::GoTo:
      return "a scene has no frames: a dataset of it has";
    case KeyAction::ToggleOverlay:
    case KeyAction::ToggleSplit:
    case KeyAction::NextView:
    case KeyAction::NextScan:
      return "a scene has no scans: a dataset of it has";
    case KeyAction::ToggleWorld:
      return "a scene has no sensor to follow";
    case KeyAction::ToggleRangeImage:
      return "a scene has no range image: a dataset of it has";
    default:
      return {};
  }
}

}  // namespace scanmill
