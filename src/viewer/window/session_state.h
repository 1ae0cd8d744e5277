#pragma once

// What the viewer knows and does; for session*.cpp alone.

#include <array>
#include <set>

#include "base/wall_timer.h"
#include "viewer/window/class_filter.h"
#include "viewer/window/draw_pace.h"
#include "viewer/window/hud.h"
#include "viewer/window/picking.h"
#include "viewer/window/range_strip.h"
#include "viewer/window/session.h"
#include "viewer/window/view_keys.h"

namespace scanmill {

constexpr std::size_t kMostSplitViews = 4;

// A scan of the frame as an item of the canvas, in one of the views.
struct ShownCloud {
  std::size_t scan = 0;
  std::size_t view = 0;
  Affine canvasFromScan;
  Coloring coloring;
  std::vector<std::uint8_t> shown;  // per point; empty: all
  std::uint64_t finite = 0;         // points
  std::uint64_t visible = 0;        // of these, those that are shown
};

// What is drawn lies in it.
struct ContentBall {
  Vec3d center;  // m, canvas's frame
  double radius = 0;
};

struct ViewNotice {
  std::string text;
  double until = 0;  // s, of State::clock
};

struct PointerDrag {
  int button = 0;  // 0: none
  bool pan = false;
  int downX = 0, downY = 0;  // px
  int x = 0, y = 0;
  bool moved = false;
  std::optional<HudRegion> slider;
};

struct ViewSession::State {
  State(std::shared_ptr<const FrameSource> frames, Canvas& drawnOn, const ViewOptions& chosen);

  // session_events.cpp
  bool handle(const CanvasEvent& event);
  void tick();
  void key(const CanvasEvent& event);
  void act(const KeyMeaning& meaning);
  void escape();
  void promptKey(const CanvasEvent& event);
  void savePicture();

  // session_pointer.cpp
  void press(const CanvasEvent& event);
  void pressRegion(const HudRegion& region, const CanvasEvent& event);
  void release(const CanvasEvent& event);
  void moveTo(const CanvasEvent& event);
  void click(int x, int y);
  void toggleMeasuring();
  void turnAbout();

  // session_frames.cpp: what is wanted, loaded and taken over
  void goTo(std::size_t frame, int step);
  void stepBy(std::ptrdiff_t count);
  void togglePlaying();
  double frameSeconds() const;  // that a frame stays while they play
  void adopt(std::shared_ptr<const ViewFrame> loaded);
  void takeWhatIsLoaded();
  void wantMesh();
  void takeMesh(std::shared_ptr<const ViewMesh> loaded);
  bool meshOn() const { return options.mesh || source->isScene(); }
  std::vector<std::string> problems() const;

  // session_clouds.cpp: points, colours, filters
  void arrange();
  void recolor(std::size_t view);
  void applyFilter();
  bool overlaid() const { return options.layout == ViewLayout::Overlay && frame && frame->scans.size() > 1; }
  std::size_t viewCount() const;
  std::size_t shownScan() const;  // of layout One
  Coloring colored(std::size_t scan, std::size_t view);
  ColorContext contextOf(const ViewScan& scan) const;
  ColorBy colorOf(std::size_t view) const;
  bool hasColor(const ViewScan& scan, ColorBy by) const;
  void chooseColor(ColorBy by);
  void cycleColor(int step);
  std::vector<std::size_t> actedViews() const;
  void makeStrip();

  // session_scenery.cpp: frames of reference, guides, mesh, cameras
  void place();
  void placeClouds();
  void placeGuides();
  void placeMesh();
  void placeMeshLook();
  void placeMeasure();
  Affine canvasFromScan(const ViewScan& scan) const;
  void toggleWorld();
  OrbitCamera preset(View view) const;
  void setCamera(const OrbitCamera& newCamera);
  double farthest(const Vec3d& eye) const;
  double pointSize() const;

  // session_draw.cpp
  void refresh();  // HUD's panes, the views
  void flush(bool whole);
  void composeHud();
  void addLabels();
  void addTip();
  void addLabel(const Vec3d& spot, const std::string& text, bool mark);
  std::string summary() const;
  void say(const std::string& text);

  // session_pick.cpp
  std::optional<std::size_t> viewAt(int x, int y) const;
  std::optional<PickedThing> pick(int x, int y) const;
  PickedThing pickedPoint(std::size_t cloud, std::size_t point) const;
  std::optional<PickedThing> pickMesh(const SightLine& line) const;
  std::optional<PickedThing> pickStrip(int x, int y) const;
  void updateHover();

  std::shared_ptr<const FrameSource> source;
  Canvas& canvas;
  ViewOptions options;  // as they are now
  OrbitCamera camera;
  bool cameraGiven = false;  // else a scene is shown whole
  bool sceneFramed = false;  // that has been done
  FrameLoader loader;
  WallTimer clock;
  DrawPace pace;

  std::size_t wanted = 0;
  std::optional<std::size_t> at;  // the frame that is shown
  std::shared_ptr<const ViewFrame> frame;
  std::vector<Pose> trajectory;
  bool playing = false;
  double lastStep = 0;         // s
  double recordedSeconds = 0;  // between the last two frames, where one followed the other
  std::string scanName;        // of layout One; empty: the first

  std::array<std::optional<ColorBy>, kMostSplitViews> colors{};
  std::optional<std::size_t> activeView;  // that colours are chosen for; none: all
  ClassFilter filter;
  std::set<std::string> hiddenScans;  // of the overlay
  std::vector<ShownCloud> clouds;

  bool world = false;                   // stand in the world in place of following the sensor
  std::optional<Pose> worldFromAnchor;  // of the frame's first scan that has a pose
  Affine canvasFromWorld;
  std::shared_ptr<const ViewMesh> mesh;  // as on the canvas
  std::optional<SceneChoice> meshWanted;
  std::vector<std::uint8_t> meshShown;  // per triangle; empty: all
  std::vector<ContentBall> content;
  Vec3d ground;  // below the first scan's sensor, canvas's frame

  std::optional<RangeStrip> strip;
  std::size_t stripCloud = 0;

  PointerDrag drag;
  int pointerX = -1, pointerY = -1;
  std::optional<PickedThing> hover;
  std::optional<PickedThing> pinned;
  bool measuring = false;
  std::vector<Vec3d> ends;  // of the measured distance, canvas's frame
  std::optional<std::string> prompt;
  bool help = false;
  bool quit = false;

  std::string colorProblem, meshProblem, stripProblem;
  std::optional<std::string> columnMissing;  // of the options' colours
  std::vector<ViewNotice> notices;
  std::string busy;

  HudState hudState;
  HudLayout layout;
  Hud hud;
  std::vector<CanvasView> views;
  bool viewsChanged = true;  // cameras, rectangles
  bool itemsChanged = true;  // points, lines, triangles
  bool hudChanged = true;
  bool hoverChanged = false;
  bool partial = false;  // the last picture had not all points
  std::uint64_t lastMost = 0;
  double lastChange = 0;      // s, of anything but what lies over the points
  double wholeSeconds = 0;    // that a picture of all points took
  double lastPicture = 0;     // s
  double pictureSeconds = 0;  // that it took
};

}  // namespace scanmill
