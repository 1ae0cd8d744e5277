#pragma once

// The state of the viewer, in parts of which each reads those before it, and the functions that connect them: events,
// the actions of keys, frames that arrive, panels that are clicked. Included only by session*.cpp.

#include "viewer/window/clouds.h"
#include "viewer/window/panels.h"
#include "viewer/window/playback.h"
#include "viewer/window/pointer.h"
#include "viewer/window/scenery.h"
#include "viewer/window/session.h"
#include "viewer/window/session_context.h"
#include "viewer/window/view_keys.h"

namespace scanmill {

struct ViewSession::State {
  State(std::shared_ptr<const FrameSource> frames, std::unique_ptr<FrameLoader> loader, Canvas& canvas,
        const ViewOptions& chosen);

  // session_events.cpp
  bool handle(const CanvasEvent& event);
  void tick();
  void key(const CanvasEvent& event);
  void act(const KeyMeaning& meaning);
  void escape();
  std::pair<bool*, const char*> switchOf(KeyAction action);  // null: the action is no switch
  void chooseColor(const ColorBy& by);
  void cycleColor(int step);
  void toggleWorld();
  void toggleAlone();
  void savePicture();

  // session_scene_keys.cpp
  std::string sceneLacks(const KeyMeaning& meaning) const;  // why a key does nothing for a scene; empty: it works
  std::string sceneLacks(const ColorBy& by) const;

  // session_frames.cpp: frames and scenes that are requested, loaded and shown
  void goTo(std::size_t frame, int step);
  void stepBy(std::ptrdiff_t count);
  void togglePlaying();
  void changeSpeed(int step);
  void hintAtNames();
  void takeWhatIsLoaded();
  void showFrame(std::shared_ptr<const ViewFrame> loaded);
  void arrange();
  void applyFilter();
  void wantMesh();
  void takeMesh(std::shared_ptr<const ViewMesh> loaded);
  void placeMesh();
  std::vector<std::string> problems() const;

  // session_draw.cpp
  void refresh();  // updates the panels and the views
  void updateHover();
  void flush(bool whole);

  // session_panels.cpp, session_instances.cpp: by Dear ImGui
  void runPanels();
  void drawPanels();
  void drawMenus();
  bool isOn(KeyAction action);
  void drawColumns();
  void drawLegends(bool ofScales);
  void pressLegend(const LegendEntry& entry, bool alone);
  void drawInstances();
  void drawStrip();
  void drawFrameBar();
  void drawPrompt();
  void drawTips();
  void drawSources();

  SessionContext context;
  Playback playback;
  Clouds clouds;
  Scenery scenery;
  Pointer pointer;
  Panels panels;
  bool quit = false;
};

}  // namespace scanmill
