#pragma once

// The viewer: its contents, and its response to keys and the pointer. It draws on a canvas and does not depend on a
// window system, so the same code draws windows and pictures, and tests can send key events without a display.

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "viewer/window/panel_contents.h"

namespace scanmill {

class ViewSession {
 public:
  // `loader`: a loader of the source that was started before the canvas was opened; null: a new one. Throws InputError
  // if an option names a sample or a class that does not exist, or colours that a scene cannot have.
  ViewSession(std::shared_ptr<const FrameSource> source, Canvas& canvas, const ViewOptions& options,
              std::unique_ptr<FrameLoader> loader = nullptr);
  ViewSession& operator=(ViewSession&&) = delete;  // neither copied nor moved

  // Handles an event. Returns false if the session is to be closed.
  bool handle(const CanvasEvent& event);
  // Waits until everything is loaded, and draws the picture with all points.
  void drawWhenLoaded();
  // Must be called after drawWhenLoaded(). Throws InputError if the scans lack a column that the options name, or if no
  // point is in the close-up; throws Error if nothing of the frame could be loaded.
  void check() const;
  // Returns the picture that drawWhenLoaded() has drawn.
  Image picture() { return context_.canvas.read(); }

  const OrbitCamera& camera() const { return sceneView_.camera; }
  void setCamera(const OrbitCamera& camera) { sceneView_.setCamera(camera); }
  // Returns the point or the triangle at a pixel of the canvas; nothing if there is none.
  std::optional<PickedElement> pick(int x, int y);
  // Selects a point or a triangle as a click does.
  void pin(const PickedElement& picked);
  // Returns a line for each part of the shown frame that could not be loaded or coloured.
  std::vector<std::string> problems() const;
  // Returns hints for the user, each of which is shown once.
  const std::vector<std::string>& hints() const { return context_.hints; }
  // Returns all commands, in the order of the menus.
  static const std::vector<ViewCommand>& commands();

 private:
  // Functions in session_events.cpp:
  void handleButtonOrWheel(const CanvasEvent& event);
  void tick();
  void execute(const ViewCommand& command);
  void escape();
  void resizePoints(int pixels);
  void toggleProjection();
  void openPrompt();
  void nextScan();
  void toggleMap();
  void toggleLayout(ViewLayout layout);
  void nextBackground();
  void nextBoxes();
  void nextView();
  void switchOption(bool ViewOptions::*option);
  void chooseColor(const ColorBy& by);
  void cycleColor(int step);
  void toggleWorld();
  void toggleInstanceAlone();
  void showAll();
  void toggleHelp();
  void savePicture();

  // Functions in session.cpp, which request, load and show frames and scenes, and draw the picture:
  void goTo(std::size_t frame, int step);
  void stepBy(std::ptrdiff_t count);
  void togglePlaying();
  void hintAtNames();
  void takeWhatIsLoaded();
  void showFrame(std::shared_ptr<const ViewFrame> loaded);
  void arrange();
  void applyFilter();
  void wantMesh();
  void refresh();  // updates the panels and the views
  void updateHover();
  void flush(Detail detail);

  // Functions in session_panels.cpp, which draw with Dear ImGui:
  void runPanels();
  void drawPanels();
  void drawMenus();
  PanelUse panelUse() const { return context_.options.still ? PanelUse::Picture : PanelUse::Interactive; }
  void drawSidePanel();
  void drawMessagesOfSession();
  void drawColorMenu();
  enum class LegendKind { Scale, Entries };
  void drawLegends(LegendKind kind);
  void drawScaleOf(const LegendBlock& block);
  void drawEntriesOf(const Legend& legend);
  std::vector<const InstanceSummary*> sortedInstances();
  void drawInstances();
  void drawStrip();
  void drawFrameBar();
  void drawPrompt();
  void drawTooltip();

  // Each part uses only the parts that are listed before it.
  SessionContext context_;
  Playback playback_;
  ShownClouds clouds_;
  SceneView sceneView_;
  Pointer pointer_;
  PanelContents panels_;
  bool quit_ = false;
};

}  // namespace scanmill
