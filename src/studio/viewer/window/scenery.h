#pragma once

// Everything on the canvas except points, and where it is: the camera, the frames of reference, the scene's mesh, axes,
// range rings, the trajectory, and the boxes of objects and instances.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/frames/view_mesh.h"
#include "viewer/window/clouds.h"
#include "viewer/window/guides.h"
#include "viewer/window/instance_summary.h"
#include "viewer/window/mesh_coloring.h"
#include "viewer/window/orbit_camera.h"
#include "viewer/window/picking.h"
#include "viewer/window/session_context.h"
#include "viewer/window/session_items.h"

namespace scanmill {

// A ball about a sensor that encloses the points of its scan.
struct ContentBall {
  Vec3d center;  // m, canvas's frame
  double radius = 0;
};

struct Scenery {
  Scenery(SessionContext& context, Clouds& clouds);

  // Takes the poses of the context's frame, the `index`-th of the source.
  void takeFrame(std::size_t index);

  // scenery.cpp: poses and guides
  void placeClouds();
  void placeGuides();
  void setLines(ItemId item, const LineSet& lines, double width);
  // Lets the camera stay in the world, or follow the sensor again. Returns how positions on the canvas change; none if
  // the poses are unknown.
  std::optional<Affine> toggleWorld();
  double pointSize() const;                 // px
  double farthest(const Vec3d& eye) const;  // m, the distance of the farthest thing from the eye

  // scenery_camera.cpp
  OrbitCamera preset(View view) const;
  // Returns the camera that the options choose; it may change when a scene has been loaded.
  OrbitCamera firstCamera() const;
  // Looks at the close-up of the options, in the direction that they choose, the first time that there are points.
  void lookAtCloseUp();
  // Returns the camera as a value of --camera.
  std::string cameraText() const;
  void setCamera(const OrbitCamera& newCamera);

  // scenery_mesh.cpp: the scene's mesh
  bool meshOn() const { return context_.options.mesh || context_.source->isScene(); }
  // True if the mesh has triangles and its pose on the canvas is known.
  bool meshSeen() const {
    return mesh && meshOn() && mesh->size() > 0 && (context_.source->isScene() || worldFromAnchor);
  }
  void takeMesh(std::shared_ptr<const ViewMesh> loaded);
  // Puts the mesh on the canvas, or takes it away if it is not to be seen.
  void placeMesh();
  void placeMeshLook();
  void applyFilter();
  void chooseMeshColor(MeshColor by);
  std::optional<PickedThing> pickMesh(const SightLine& line) const;
  // Hints at a part that encloses the rest of the scene, such as a closed sky box, if nothing else is seen, from inside
  // or outside.
  void tellWhatEncloses();

  // scenery_boxes.cpp: objects that samples list, and instances
  Affine canvasFromBox(const ObjectRecord& object) const;
  const ObjectView* shownView(
      const ObjectRecord& object) const;  // the view of the object by the first scan's sensor; null: none
  void placeBoxes();
  // Returns the shown objects that the first scan's sensor sees, with their views, the nearest first, at most 30.
  std::vector<std::pair<const ObjectRecord*, const ObjectView*>> nearestSeen() const;
  void addObjectRows(PickedThing& thing, std::uint32_t instance) const;
  // Returns the instances of the first scan that is shown.
  const std::vector<InstanceSummary>& instances();

  OrbitCamera camera;
  std::vector<Pose> trajectory;         // worldFromSensor of the sequence's frames
  std::optional<Pose> worldFromAnchor;  // pose of the frame's first scan that has one
  bool world = false;                   // the camera stays in the world instead of following the sensor
  Affine canvasFromWorld;
  Vec3d ground;                          // the ground below the first scan's sensor, canvas frame
  std::shared_ptr<const ViewMesh> mesh;  // the loaded mesh; null: none
  std::optional<SceneChoice> meshWanted;
  std::string meshProblem;
  CanvasItem meshItem;
  MeshColor meshColor = MeshColor::Class;
  Coloring meshColoring;
  std::vector<std::uint8_t> meshShown;  // per triangle; empty: all
  bool instanceBoxes = false;           // boxes about the points of instances, if the sample lists no objects

 private:
  void place();
  Affine canvasFromScan(const ViewScan& scan) const;
  bool boxShown(const ObjectRecord& object) const;
  void placeInstanceBoxes(LineSet& lines);

  SessionContext& context_;
  Clouds& clouds_;
  std::vector<ContentBall> content_;
  bool framed_ = false;  // the first camera, which needs the scene's box or the scan's pose, has been set
  std::optional<std::pair<const ViewFrame*, std::size_t>> instancesOf_;  // the frame and scan of `instances_`
  std::vector<InstanceSummary> instances_;
};

// Returns the class of most of an instance's points; 0 if its points have none.
std::uint16_t classOf(const InstanceSummary& instance);

}  // namespace scanmill
