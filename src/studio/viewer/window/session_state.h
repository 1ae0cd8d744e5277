#pragma once

// What the viewer knows and does; for session*.cpp alone.

#include <array>
#include <map>
#include <set>

#include "base/wall_timer.h"
#include "viewer/panels/parts.h"
#include "viewer/panels/rooms.h"
#include "viewer/panels/toolkit.h"
#include "viewer/range_strip.h"
#include "viewer/window/class_filter.h"
#include "viewer/window/draw_pace.h"
#include "viewer/window/guides.h"
#include "viewer/window/instance_summary.h"
#include "viewer/window/mesh_coloring.h"
#include "viewer/window/picking.h"
#include "viewer/window/session.h"
#include "viewer/window/session_items.h"
#include "viewer/window/view_keys.h"

namespace scanmill {

constexpr std::size_t kMostSplitViews = 4;

// How fast frames are played; 0: as fast as they load.
constexpr std::array<double, 5> kPlaySpeeds{0.5, 1, 2, 5, 0};
constexpr std::size_t kUsualSpeed = 1;

enum class Selecting { None, Box, Lasso };

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
  double until = 0;               // s, of State::clock
  std::optional<KeyAction> of{};  // that said it
};

// An instance in a scan of the frame.
struct InstancePlace {
  std::size_t scan = 0;
  std::uint32_t id = 0;
  bool operator==(const InstancePlace&) const = default;
};

// By scan of the frame, ascending.
using PointsOfScans = std::map<std::size_t, std::vector<std::uint32_t>>;

struct PointerDrag {
  int button = 0;  // 0: none
  bool pan = false;
  int downX = 0, downY = 0;  // px
  int x = 0, y = 0;
  bool moved = false;
};

// One of the views side by side.
struct ViewPane {
  std::string caption;  // what is shown: "top, ray_tracing"; written where there are several
  Legend legend;
  bool active = false;  // what keys change
  std::string message;  // why nothing is to be seen
};

// What colours mean, in all views where they mean the same.
struct LegendBlock {
  Legend legend;
  std::vector<std::size_t> views;
};

struct ViewSession::State {
  State(std::shared_ptr<const FrameSource> frames, std::unique_ptr<FrameLoader> frameLoader, Canvas& drawnOn,
        const ViewOptions& chosen);

  // session_events.cpp
  bool handle(const CanvasEvent& event);
  void tick();
  void key(const CanvasEvent& event);
  void act(const KeyMeaning& meaning);
  void escape();
  std::pair<bool*, const char*> switchOf(KeyAction action);  // null: nothing is switched
  void savePicture();

  // session_scene_keys.cpp
  std::string sceneLacks(const KeyMeaning& meaning) const;  // why a key means nothing for a scene; empty: it does
  std::string sceneLacks(const ColorBy& by) const;
  void chooseMeshColor(MeshColor by);

  // session_pointer.cpp
  void press(const CanvasEvent& event);
  void release(const CanvasEvent& event);
  void moveTo(const CanvasEvent& event);
  void click(int x, int y);
  void toggleMeasuring();
  void turnAbout();
  void toggleAlone();

  // session_frames.cpp: what is wanted, loaded and taken over
  void goTo(std::size_t frame, int step);
  void wantFrame(std::size_t frame, int step);
  void stepBy(std::ptrdiff_t count);
  void togglePlaying();
  void changeSpeed(int step);
  std::string speedText() const;
  void seekReadable();
  void hintAtNames();
  double frameSeconds() const;  // that a frame stays while they play
  void adopt(std::shared_ptr<const ViewFrame> loaded);
  void takeWhatIsLoaded();
  void wantMesh();
  void takeMesh(std::shared_ptr<const ViewMesh> loaded);
  bool meshOn() const { return options.mesh || source->isScene(); }
  // There are triangles, and a place for them.
  bool meshSeen() const { return mesh && meshOn() && mesh->size() > 0 && (source->isScene() || worldFromAnchor); }
  std::vector<std::string> problems() const;

  // session_clouds.cpp: points, colours, filters
  void arrange();
  void recolor(std::size_t view);
  void applyFilter();
  bool overlaid() const { return options.layout == ViewLayout::Overlay && frame && frame->scans.size() > 1; }
  std::size_t viewCount() const;
  std::size_t shownScan() const;  // of layout One
  Coloring colored(std::size_t scan, std::size_t view);
  std::optional<ScaleRange> scaleOf(std::size_t view);
  void changeScale(KeyAction change);
  ColorContext contextOf(const ViewScan& scan) const;
  ColorBy colorOf(std::size_t view) const;
  bool hasColor(const ViewScan& scan, const ColorBy& by) const;
  void chooseColor(const ColorBy& by);
  void cycleColor(int step);
  std::vector<std::size_t> actedViews() const;
  void makeStrip();

  // session_scenery.cpp: frames of reference, guides, mesh, cameras
  void place();
  void placeClouds();
  void placeGuides();
  void placeMesh();
  void tellWhatEncloses();
  void placeMeshLook();
  void placeMeasure();
  void setLines(ItemId item, const LineSet& lines, double width);
  Affine canvasFromScan(const ViewScan& scan) const;
  void toggleWorld();
  OrbitCamera preset(View view) const;
  // What was asked for; of a scene that is not there yet it may be another.
  OrbitCamera firstCamera() const;
  // For --camera.
  std::string cameraText() const;
  void setCamera(const OrbitCamera& newCamera);
  double farthest(const Vec3d& eye) const;
  double pointSize() const;

  // session_boxes.cpp: objects that samples list
  Affine canvasFromBox(const ObjectRecord& object) const;
  const ObjectView* shownView(const ObjectRecord& object) const;  // by the sensor of the first scan; null: none
  bool boxShown(const ObjectRecord& object) const;
  void placeBoxes();
  void addBoxLabels();
  void addObjectRows(PickedThing& thing, std::uint32_t instance) const;

  // session_selection.cpp
  void startSelecting(Selecting how);
  void clearSelection();
  void addToOutline(int x, int y);
  void select();  // what lies in the outline
  void placeSelection();
  void drawSelection();
  void saveSelection();

  // session_instances.cpp
  const std::vector<InstanceSummary>& instances();
  void placeInstanceBoxes(LineSet& lines);
  void drawInstances();
  void placeBeam();

  // session_draw.cpp
  void refresh();  // what colours mean, the views
  void flush(bool whole);
  void addLabels();
  void addLabel(const Vec3d& spot, const std::string& text, bool mark);
  std::string title() const;
  std::string summary() const;

  // session_legends.cpp
  void completeClasses(Legend& legend) const;
  void collectLegends();
  void addMessages();
  bool isHidden(const LegendEntry& entry) const;
  void pressLegend(const LegendEntry& entry, bool alone);

  // session_panels.cpp: by Dear ImGui
  void runPanels();
  void drawPanels();
  void drawMenus();
  bool isOn(KeyAction action);
  void drawColumns();
  void drawLegends(bool ofScales);
  void drawStrip();
  void drawFrameBar();
  void drawPrompt();
  void drawTips();
  void drawSources();
  void say(const std::string& text, double seconds = 4);
  void hint(const std::string& text);

  // session_pick.cpp
  std::optional<std::size_t> viewAt(int x, int y) const;
  std::optional<PickedThing> pick(int x, int y) const;
  PickedThing pickedPoint(std::size_t cloud, std::size_t point) const;
  std::optional<PickedThing> pickMesh(const SightLine& line) const;
  std::optional<PickedThing> pickStrip(int x, int y) const;
  PixelRect stripRect() const;  // of its image
  PickedThing inFull(PickedThing thing) const;
  bool isShown(const PickedThing& thing) const;
  void updateHover();

  // session_tip.cpp: what is told of it, and its instance
  Rgb colorOf(const PickedThing& thing) const;
  std::optional<std::uint32_t> instanceOf(const PickedThing& thing) const;  // none: of no instance
  const InstanceSummary& summaryOf(const ShownCloud& cloud, std::uint32_t instance) const;
  void lightInstance();
  // Points by scan of the frame, once more in white so that they edge what they belong to. `anew`: other points.
  void edge(CanvasItem& item, const PointsOfScans& points, bool anew);

  std::shared_ptr<const FrameSource> source;
  Canvas& canvas;
  ViewOptions options;  // as they are now
  OrbitCamera camera;
  bool sceneFramed = false;  // a scene's first camera has been set, which wants its box
  std::unique_ptr<FrameLoader> loader;
  WallTimer clock;
  DrawPace pace;

  std::size_t wanted = 0;
  std::optional<std::size_t> at;  // the frame that is shown
  std::shared_ptr<const ViewFrame> frame;
  std::vector<Pose> trajectory;
  bool readsAhead = false;  // further frames are loaded
  bool playing = false;
  double lastStep = 0;                     // s
  double recordedSeconds = 0;              // between the last two frames, where one followed the other
  std::size_t speed = kUsualSpeed;         // into kPlaySpeeds
  bool seeking = false;                    // no frame was asked for: the first that can be read will do
  std::size_t firstWanted = 0;             // where seeking began
  std::size_t seekAt = 0;                  // the next frame to try
  std::set<std::size_t> unreadable;        // frames that were loaded in vain
  std::set<std::uint16_t> presentClasses;  // that a frame holds, as far as is known
  bool classesKnown = false;               // of all frames
  std::string scanName;                    // of layout One; empty: the first

  std::array<std::optional<ColorBy>, kMostSplitViews> colors{};
  std::array<std::optional<ScaleRange>, kMostSplitViews> scales{};  // where they do not follow from the values
  std::map<ColorBy, ScaleRange> commonScales;                       // of the frame's scans side by side
  std::optional<std::size_t> activeView;                            // that colours are chosen for; none: all
  ClassFilter filter;
  std::set<std::uint32_t> aloneInstances;  // instances that alone are shown; empty: all
  std::set<std::string> hiddenScans;       // of the overlay
  std::vector<ShownCloud> clouds;

  bool world = false;                   // stand in the world in place of following the sensor
  std::optional<Pose> worldFromAnchor;  // of the frame's first scan that has a pose
  Affine canvasFromWorld;
  std::shared_ptr<const ViewMesh> mesh;  // that was loaded
  CanvasItem meshItem{canvas, kMeshItem};
  std::optional<SceneChoice> meshWanted;
  MeshColor meshColor = MeshColor::Class;
  Coloring meshColoring;
  std::vector<std::uint8_t> meshShown;  // per triangle; empty: all
  std::vector<ContentBall> content;
  Vec3d ground;  // below the first scan's sensor, canvas's frame

  std::optional<RangeStrip> strip;
  std::size_t stripCloud = 0;

  PointerDrag drag;
  int pointerX = -1, pointerY = -1;
  std::optional<PickedThing> hover;
  std::optional<PickedThing> pinned;
  mutable std::optional<std::pair<InstancePlace, InstanceSummary>> lastSummary;
  std::optional<InstancePlace> lit;  // as on the canvas
  PointsOfScans litPoints;
  CanvasItem litItem{canvas, kLitItem};
  double lastMove = 0;  // s, of the pointer
  Selecting selecting = Selecting::None;
  std::vector<Vec2d> outline;  // px, canvas
  PointsOfScans selected;
  CanvasItem selectedItem{canvas, kSelectedItem};
  bool instanceBoxes = false;  // about the points, where the sample lists no objects
  std::optional<std::pair<const ViewFrame*, std::size_t>> instancesOf;
  std::vector<InstanceSummary> allInstances;
  std::optional<std::pair<std::size_t, std::size_t>> beamOf;  // scan and point whose beam's returns are joined
  bool beamDrawn = false;
  bool measuring = false;
  std::vector<Vec3d> ends;  // of the measured distance, canvas's frame
  std::optional<std::string> prompt;
  bool help = false;
  bool quit = false;

  std::string colorProblem, meshProblem, stripProblem, instanceProblem;
  std::optional<std::string> columnMissing;  // of the options' colours
  std::vector<ViewNotice> notices;
  std::vector<std::string> hints;
  std::optional<KeyAction> acting;  // of the key that is being obeyed
  std::string busy;

  Toolkit toolkit;
  PanelRooms rooms;
  std::vector<ViewPane> panes;
  std::vector<LegendBlock> legends;
  std::vector<PanelLabel> labels;
  std::vector<std::size_t> damaged;  // frames that cannot be shown; ascending
  bool overStrip = false;            // the pointer is over the range image
  std::vector<CanvasView> views;
  bool viewsChanged = true;  // cameras, rectangles
  bool itemsChanged = true;  // points, lines, triangles
  bool hudChanged = true;
  bool lightChanged = false;  // the points of the instance that is pointed at
  bool hoverChanged = false;
  bool partial = false;  // the last picture had not all points
  std::uint64_t lastMost = 0;
  double lastChange = 0;      // s, of anything but what lies over the points
  double wholeSeconds = 0;    // that a picture of all points took
  double lastPicture = 0;     // s
  double pictureSeconds = 0;  // that it took
};

}  // namespace scanmill
