#pragma once

// The state of the viewer, and the functions that handle events, actions of keys, loaded frames and clicks in panels.
// The state consists of parts; each part uses only the parts that are listed before it. Included only by session*.cpp.

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

  // Returns the quantity that the action ColorByNumber chooses.
  static ColorBy colorOf(const KeyMeaning& meaning) {
    return ColorBy(colorNames()[static_cast<std::size_t>(meaning.number)]);
  }

  // Functions in session_events.cpp:
  bool handle(const CanvasEvent& event);
  void tick();
  void key(const CanvasEvent& event);
  void act(const KeyMeaning& meaning);
  void escape();
  std::pair<bool*, const char*> switchOf(KeyAction action);
  void chooseColor(const ColorBy& by);
  void cycleColor(int step);
  void toggleWorld();
  void toggleAlone();
  void savePicture();
  // Return why a key or quantity cannot be used for a scene; empty: it can.
  std::string sceneLacks(const KeyMeaning& meaning) const;
  std::string sceneLacks(const ColorBy& by) const;

  // Functions in session.cpp, which request, load and show frames and scenes, and draw the picture:
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
  void refresh();  // updates the panels and the views
  void updateHover();
  void flush(bool whole);

  // Functions in session_panels.cpp, which draw with Dear ImGui:
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
