#pragma once

// The state and the functions of the viewer; included only by session*.cpp.

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

// Factors of the speed at which frames are played; 0: as fast as they load.
constexpr std::array<double, 5> kPlaySpeeds{0.5, 1, 2, 5, 0};
constexpr std::size_t kUsualSpeed = 1;

// A scan of the frame as an item of the canvas, in one of the views.
struct ShownCloud {
  std::size_t scan = 0;
  std::size_t view = 0;
  Affine canvasFromScan;
  Coloring coloring;
  std::vector<std::uint8_t> shown;  // per point; empty: all
  std::uint64_t finite = 0;         // number of finite points
  std::uint64_t visible = 0;        // number of finite points that are shown
};

// A ball about a sensor that encloses the points of its scan.
struct ContentBall {
  Vec3d center;  // m, canvas's frame
  double radius = 0;
};

struct ViewNotice {
  std::string text;
  double until = 0;               // s, of State::clock
  std::optional<KeyAction> of{};  // the action that caused it
};

// An instance in a scan of the frame.
struct InstancePlace {
  std::size_t scan = 0;
  std::uint32_t id = 0;
  bool operator==(const InstancePlace&) const = default;
};

// Point indices, ascending, by the index of their scan in the frame.
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
  std::string caption;  // name of its scan: "top, ray_tracing"; drawn if there are several views
  Legend legend;
  bool active = false;  // keys act on this view
  std::string message;  // why the view shows nothing
};

// A legend, and the views that share it.
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
  std::pair<bool*, const char*> switchOf(KeyAction action);  // null: the action is no switch
  void savePicture();

  // session_scene_keys.cpp
  std::string sceneLacks(const KeyMeaning& meaning) const;  // why a key does nothing for a scene; empty: it works
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

  // session_frames.cpp: frames and scenes that are requested, loaded and shown
  void goTo(std::size_t frame, int step);
  void wantFrame(std::size_t frame, int step);
  void stepBy(std::ptrdiff_t count);
  void togglePlaying();
  void changeSpeed(int step);
  std::string speedText() const;
  void seekReadable();
  void hintAtNames();
  double frameSeconds() const;  // how long each frame is shown while playing
  void adopt(std::shared_ptr<const ViewFrame> loaded);
  void takeWhatIsLoaded();
  void wantMesh();
  void takeMesh(std::shared_ptr<const ViewMesh> loaded);
  bool meshOn() const { return options.mesh || source->isScene(); }
  // True if the mesh has triangles and its pose on the canvas is known.
  bool meshSeen() const { return mesh && meshOn() && mesh->size() > 0 && (source->isScene() || worldFromAnchor); }
  std::vector<std::string> problems() const;

  // session_clouds.cpp: points, colours, filters
  void arrange();
  void recolor(std::size_t view);
  void applyFilter();
  bool overlaid() const { return options.layout == ViewLayout::Overlay && frame && frame->scans.size() > 1; }
  std::size_t viewCount() const;
  std::size_t shownScan() const;  // index of the scan in layout One
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
  // Returns the camera that the options choose; it may change when a scene has been loaded.
  OrbitCamera firstCamera() const;
  // Returns the camera as a value of --camera.
  std::string cameraText() const;
  void setCamera(const OrbitCamera& newCamera);
  double farthest(const Vec3d& eye) const;
  double pointSize() const;

  // session_boxes.cpp: objects that samples list
  Affine canvasFromBox(const ObjectRecord& object) const;
  const ObjectView* shownView(const ObjectRecord& object) const;  // of the first scan's sensor; null: none
  bool boxShown(const ObjectRecord& object) const;
  void placeBoxes();
  void addBoxLabels();
  void addObjectRows(PickedThing& thing, std::uint32_t instance) const;

  // session_instances.cpp
  const std::vector<InstanceSummary>& instances();
  void placeInstanceBoxes(LineSet& lines);
  void drawInstances();
  void placeBeam();

  // session_draw.cpp
  void refresh();  // updates the legends and the views
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
  PixelRect stripRect() const;  // px: rectangle of the range image
  PickedThing inFull(PickedThing thing) const;
  bool isShown(const PickedThing& thing) const;
  void updateHover();

  // session_tip.cpp: the description of a picked point, and its instance
  Rgb colorOf(const PickedThing& thing) const;
  std::optional<std::uint32_t> instanceOf(const PickedThing& thing) const;  // none: belongs to no instance
  const InstanceSummary& summaryOf(const ShownCloud& cloud, std::uint32_t instance) const;
  void lightInstance();
  // Draws points once more in white, larger and farther away, as an outline. `anew`: the points have changed.
  void edge(CanvasItem& item, const PointsOfScans& points, bool anew);

  std::shared_ptr<const FrameSource> source;
  Canvas& canvas;
  ViewOptions options;  // the current ones
  OrbitCamera camera;
  bool sceneFramed = false;  // the first camera of a scene, which needs the scene's box, has been set
  std::unique_ptr<FrameLoader> loader;
  WallTimer clock;
  DrawPace pace;

  std::size_t wanted = 0;
  std::optional<std::size_t> at;  // the frame that is shown
  std::shared_ptr<const ViewFrame> frame;
  std::vector<Pose> trajectory;
  bool readsAhead = false;  // further frames are loaded in advance
  bool playing = false;
  double lastStep = 0;                     // s, time when the frame was shown or playing began
  double recordedSeconds = 0;              // time between the last two frames shown, if they are consecutive
  std::size_t speed = kUsualSpeed;         // index into kPlaySpeeds
  bool seeking = false;                    // the user chose no frame: the first readable frame is shown
  std::size_t firstWanted = 0;             // where seeking began
  std::size_t seekAt = 0;                  // the next frame to try
  std::set<std::size_t> unreadable;        // frames that could not be loaded
  std::set<std::uint16_t> presentClasses;  // classes known to occur in a frame
  bool classesKnown = false;               // presentClasses covers all frames
  std::string scanName;                    // the scan shown in layout One; empty: the first

  std::array<std::optional<ColorBy>, kMostSplitViews> colors{};
  std::array<std::optional<ScaleRange>, kMostSplitViews> scales{};  // chosen ones; absent: follow from the values
  std::map<ColorBy, ScaleRange> commonScales;                       // shared by the frame's scans side by side
  std::optional<std::size_t> activeView;                            // the view whose colours change; none: all
  ClassFilter filter;
  std::set<std::uint32_t> aloneInstances;  // the only instances that are shown; empty: all
  std::set<std::string> hiddenScans;       // scans hidden in the overlay layout
  std::vector<ShownCloud> clouds;

  bool world = false;                   // the camera stays in the world instead of following the sensor
  std::optional<Pose> worldFromAnchor;  // pose of the frame's first scan that has one
  Affine canvasFromWorld;
  std::shared_ptr<const ViewMesh> mesh;  // the loaded mesh
  CanvasItem meshItem{canvas, kMeshItem};
  std::optional<SceneChoice> meshWanted;
  MeshColor meshColor = MeshColor::Class;
  Coloring meshColoring;
  std::vector<std::uint8_t> meshShown;  // per triangle; empty: all
  std::vector<ContentBall> content;
  Vec3d ground;  // the ground below the first scan's sensor, canvas frame

  std::optional<RangeStrip> strip;
  std::size_t stripCloud = 0;

  PointerDrag drag;
  int pointerX = -1, pointerY = -1;
  std::optional<PickedThing> hover;
  std::optional<PickedThing> pinned;
  mutable std::optional<std::pair<InstancePlace, InstanceSummary>> lastSummary;
  std::optional<InstancePlace> lit;  // the instance that is highlighted on the canvas
  PointsOfScans litPoints;
  CanvasItem litItem{canvas, kLitItem};
  double lastMove = 0;  // s, time of the pointer's last move
  bool instanceBoxes = false;  // boxes about the points of instances, if the sample lists no objects
  std::optional<std::pair<const ViewFrame*, std::size_t>> instancesOf;
  std::vector<InstanceSummary> allInstances;
  std::optional<std::pair<std::size_t, std::size_t>> beamOf;  // scan and point whose beam is drawn through its returns
  bool beamDrawn = false;
  bool measuring = false;
  std::vector<Vec3d> ends;  // ends of the measured distance, canvas frame
  std::optional<std::string> prompt;
  bool help = false;
  bool quit = false;

  std::string colorProblem, meshProblem, stripProblem, instanceProblem;
  std::optional<std::string> columnMissing;  // message about a column in the options' colours
  std::vector<ViewNotice> notices;
  std::vector<std::string> hints;
  std::optional<KeyAction> acting;  // the action that is being executed
  std::string busy;

  Toolkit toolkit;
  PanelRooms rooms;
  std::vector<ViewPane> panes;
  std::vector<LegendBlock> legends;
  std::vector<PanelLabel> labels;
  std::vector<std::size_t> damaged;  // frames that cannot be shown; ascending
  bool overStrip = false;            // the pointer is over the range image
  std::vector<CanvasView> views;
  bool viewsChanged = true;  // cameras or rectangles have changed
  bool itemsChanged = true;  // points, lines or triangles have changed
  bool hudChanged = true;
  bool lightChanged = false;  // the highlighted points have changed
  bool hoverChanged = false;
  bool partial = false;  // the last picture did not show all points
  std::uint64_t lastMost = 0;
  double lastChange = 0;      // s, time of the last change of anything except the overlay
  double wholeSeconds = 0;    // time that a picture of all points took
  double lastPicture = 0;     // s, time of the last picture
  double pictureSeconds = 0;  // time that the last picture took
};

}  // namespace scanmill
