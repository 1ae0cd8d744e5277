#pragma once

// Everything on the canvas: the points of the frame's scans and, around them, the camera, the frames of reference, the
// scene's mesh, axes, range rings, the trajectory, and the boxes of objects and instances.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "viewer/range_strip.h"
#include "viewer/window/canvas_items.h"
#include "viewer/window/picking.h"
#include "viewer/window/session_context.h"

namespace scanmill {

// A scan of the frame as an item of the canvas, in one of the views.
struct ShownCloud {
  std::size_t scan = 0;  // index in the frame
  std::size_t view = 0;
  Affine canvasFromScan{};
  Coloring coloring{};
  std::vector<std::uint8_t> shown{};  // for each point, 1 if it is shown; empty: all are shown
  std::uint64_t finite = 0;           // number of finite points
  std::uint64_t visible = 0;          // number of finite points that are shown
};

// Shows the scans of the frame as points on the canvas: chooses the scan of each view, its colours and its visible
// points. Also draws the range image of one of the scans.
struct ShownClouds {
  explicit ShownClouds(SessionContext& context);

  // Creates the canvas items of the frame's scans for the current layout, and removes the items of other scans.
  void arrange();
  // Shows only the points that the filter does not hide.
  void applyFilter();
  // Draws the range image of one of the shown scans, if the options require one, and uploads it.
  void makeStrip();

  // True if all scans of the frame are in one view, each in a fixed colour.
  bool overlaid() const { return context_.options.layout == ViewLayout::Overlay && context_.scanCount() > 1; }
  std::size_t viewCount() const;
  std::size_t shownScan() const;  // returns the index of the scan that the layout One shows
  ColorBy colorOf(std::size_t view) const;
  bool hasColor(const ViewScan& scan, const ColorBy& by) const;
  const ShownCloud* inView(std::size_t view) const;  // returns the first cloud in the view; null if there is none
  const ViewScan& scanOf(const ShownCloud& cloud) const { return context_.frame->scans[cloud.scan]; }
  // True if the user has hidden the cloud's scan in the overlay of all scans.
  bool isHidden(const ShownCloud& cloud) const {
    return overlaid() && context_.filter.hiddenScans.contains(scanOf(cloud).name);
  }

  // chooseColor() colours by the quantity `by`; cycleColor() by the next (`step` 1) or previous (-1) quantity that the
  // scans have. Both change the active view or, if no view is active, all views. If a scan lacks `by`, chooseColor()
  // changes no colours and sets `colorProblem`.
  void chooseColor(const ColorBy& by);
  void cycleColor(int step);
  // Resets the scale of the active view, or of all views; the ends are then computed from the values again.
  void resetScales();
  // Computes the colours of a view's points again.
  void recolor(std::size_t view);

  std::vector<ShownCloud> list;
  std::array<std::optional<ColorBy>, kCanvasViews> colors{};
  // For each view, the ends of the scale that the user has chosen; absent: computed from the values.
  std::array<std::optional<ScaleRange>, kCanvasViews> scales{};
  std::optional<std::size_t> activeView;   // the view to which the user's changes of colours apply; absent: all views
  std::string scanName;                    // name of the scan that the layout One shows; empty: the first scan
  std::set<std::uint16_t> presentClasses;  // ids of classes that are known to occur in at least one frame
  std::string colorProblem, instanceProblem, stripProblem;
  std::optional<std::string> columnMissing;  // message about a column that the options name, but a scan lacks
  std::optional<RangeStrip> strip;
  std::size_t stripCloud = 0;  // index in `list` of the cloud that the range image shows

 private:
  Coloring colored(const ShownCloud& cloud);
  std::optional<std::vector<std::uint32_t>> filtered(ShownCloud& cloud) const;
  std::optional<ScaleRange> scaleOf(std::size_t view);
  ColorContext contextOf(const ViewScan& scan) const;
  bool isAffected(std::size_t view) const { return !activeView || *activeView == view; }

  SessionContext& context_;
  std::map<ColorBy, ScaleRange> commonScales_;  // ends of scales that scans side by side share
  bool classesKnown_ = false;                   // true: presentClasses contains the classes of all frames
};

// Quantities that colours can show. Object: the placed object and the node in its file. Rule: the source of the
// class, see ViewMesh::rules.
enum class MeshColor { Class, Instance, Object, Material, Texture, Rule, Reflectance };
constexpr std::array<std::string_view, 7> kMeshColorNames{"class",   "instance", "object",     "material",
                                                          "texture", "rule",     "reflectance"};

// Returns why a scene cannot be coloured by a quantity; empty if it can be.
std::string whyNoMeshColor(const ColorBy& by);

// Returns one colour per triangle. The legend counts triangles.
Coloring colorMesh(const ViewMesh& mesh, MeshColor by);

// A ball around a sensor that encloses the points of its scan.
struct ContentBall {
  Vec3d center;  // position of the sensor (m, canvas frame)
  double radius = 0;
};

// Shows everything on the canvas except points.
struct SceneView {
  SceneView(SessionContext& context, ShownClouds& clouds);

  // Sets worldFromAnchor, trajectory and canvasFromWorld for the context's frame. `index`: index of the frame.
  void takeFrame(std::size_t index);

  // Functions in scene_view.cpp, for poses, guides and the camera:
  void placeClouds();  // sets the poses and sizes of the shown clouds' points, and `ground`
  void placeGuides();  // draws axes, range rings, the trajectory, boxes and the ego vehicle, as the options say
  void setLines(ItemId item, const LineSet& lines, double width);
  // Switches between a camera that stays in the world and a camera that follows the sensor. Returns the transform from
  // the old to the new canvas frame; nothing if the poses are unknown.
  std::optional<Affine> toggleWorld();
  double pointSize() const;                 // returns the side of a drawn point (pixels)
  double farthest(const Vec3d& eye) const;  // returns an upper bound of the distance from the eye to what is drawn (m)

  OrbitCamera preset(View view) const;
  // Returns the camera that the options choose. A named view is fitted to the first frame or the scene's mesh; the
  // result may change when the frame or mesh has been loaded.
  OrbitCamera firstCamera() const;
  // When the first points are shown, moves the camera to firstCamera(), or to the close-up if the options have one.
  void lookAtFirstPoints();
  // Returns the camera as a value of --camera.
  std::string cameraText() const;
  void setCamera(const OrbitCamera& newCamera);
  // Calls change(copy) with a copy of the camera, and sets the camera to the changed copy.
  void changeCamera(const auto& change) {
    OrbitCamera changed = camera;
    change(changed);
    setCamera(changed);
  }

  // Functions for the scene's mesh, most of them in scene_view_mesh.cpp:
  bool isMeshOn() const { return context_.options.mesh || context_.source->isScene(); }
  // True if the mesh is switched on and has triangles, and its pose on the canvas is known.
  bool isMeshVisible() const {
    return mesh && isMeshOn() && mesh->size() > 0 && (context_.source->isScene() || worldFromAnchor);
  }
  void takeMesh(std::shared_ptr<const ViewMesh> loaded);
  // Adds the mesh to the canvas, or removes it if isMeshVisible() is false.
  void placeMesh();
  void placeMeshLook();
  // Draws the ego vehicle at its pose, if the dataset has one and the axes are on.
  void placeVehicle();
  void applyFilter();  // shows only the triangles of the mesh that the filter does not hide
  void chooseMeshColor(MeshColor by);
  std::optional<PickedElement> pickMesh(const SightLine& line) const;

  // Functions in scene_view_mesh.cpp, for instances and for the objects in the list of a sample:
  Affine canvasFromBox(const ObjectRecord& object) const;
  // Returns how the first scan's sensor sees the object; null if this is not known.
  const ObjectView* viewOfShownSensor(const ObjectRecord& object) const;
  void placeBoxes();  // draws the boxes of objects and of instances that isBoxShown() and the filter allow
  // Returns the shown objects that the first scan's sensor sees, with their views: at most 30, the nearest first.
  std::vector<std::pair<const ObjectRecord*, const ObjectView*>> nearestSeenObjects() const;
  void addObjectRows(PickedElement& picked, std::uint32_t instance) const;
  // Returns summaries of the instances in the first shown scan.
  const std::vector<InstanceSummary>& instances();

  OrbitCamera camera;
  bool isFitted = false;                // true: the camera has been fitted to the first frame or the scene's mesh
  std::vector<Pose> trajectory;         // sensor poses (worldFromSensor) in all frames of the sequence
  std::optional<Pose> worldFromAnchor;  // sensor pose of the frame's first scan whose pose is known
  bool staysInWorld = false;            // true: the camera stays in the world; false: it follows the sensor
  Affine canvasFromWorld;
  Vec3d ground;                          // point of the ground below the first scan's sensor (canvas frame)
  std::shared_ptr<const ViewMesh> mesh;  // the loaded mesh; null: none is loaded
  std::optional<SceneChoice> meshWanted;
  std::string meshProblem;
  bool meshPlaced = false;  // true: the canvas has the mesh
  MeshColor meshColor = MeshColor::Class;
  Coloring meshColoring;
  std::vector<std::uint8_t> meshShown;  // for each triangle, 1 if it is shown; empty: all are shown
  bool instanceBoxes = false;           // true: draws boxes around instances' points if the sample lists no objects

 private:
  void computeCanvasFrame();
  OrbitCamera closeUpCamera(const CloseUp& closeUp) const;
  std::vector<Vec3d> pointsOnCanvas() const;
  void findRoadUsers();
  bool isBoxShown(const ObjectRecord& object) const;
  void addObjectBox(LineSet& lines, const ObjectRecord& object) const;
  std::uint32_t allViews() const { return (1U << clouds_.viewCount()) - 1; }  // see ItemLook::views

  SessionContext& context_;
  ShownClouds& clouds_;
  std::vector<ContentBall> contents_;                                   // one per shown cloud
  std::optional<std::pair<const ViewFrame*, std::size_t>> summarized_;  // frame and scan of the cached `instances_`
  std::vector<InstanceSummary> instances_;
  std::optional<ViewMesh> vehicle_;    // mesh of the ego vehicle, once it has been loaded
  bool vehiclePlaced_ = false;         // true: the canvas has `vehicle_`
  std::set<std::uint16_t> roadUsers_;  // classes of road users in the source's ontology
};

// Returns the most frequent class of an instance's points; 0 if its points have no classes.
std::uint16_t classOf(const InstanceSummary& instance);

}  // namespace scanmill
