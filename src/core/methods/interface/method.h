#pragma once

// The interface of a method, which turns a shot into Hits. To add a method, add a file and a row in methods()
// (methods/method.h).

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "methods/interface/trace_account.h"
#include "scan/channels.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

class DepthCamera;
class Worlds;

// All calls are safe from several threads at once. A method may cache data between calls, such as the hierarchy around
// a sensor; a cache never changes a result.
class Method {
 public:
  virtual ~Method() = default;
  // Does the set-up that trace() would do first for a shot at this position, such as building a hierarchy, so that
  // set-up and tracing can be timed separately. Never changes a result.
  virtual TraceAccount prepare(const Shot& shot) const = 0;
  // Fills `hits` with the channels asked for; the result depends on the shot alone. A hit nearer than the sensor's
  // minimum range, or farther than its maximum, is a miss.
  virtual TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const = 0;
  // Returns what the method models of the scene and what it leaves out, one line each, for `plan` and the manifest.
  virtual std::vector<std::string> modelled() const = 0;
  // Returns about how many bytes the scene's own meshes and all that the method caches take, as far as they are loaded
  // now; `plan` reports it.
  virtual std::uint64_t memoryBytes() const = 0;
  // Returns this method if it renders passes that can be saved (MethodCapabilities::passes), else null.
  virtual const DepthCamera* depthCamera() const { return nullptr; }
  // Returns the method's hierarchies of the scene's own triangles, built with thingFilter()
  // (methods/ray_tracing/unobstructed.h) for occlusions, if it has some that others may share; else null.
  virtual const Worlds* worlds() const { return nullptr; }
};

// The capabilities of a method. The plan refuses a pipeline that asks for more.
struct MethodCapabilities {
  bool severalHits = false;  // several hits along a ray, one behind the other; else only the first
  bool footprints = false;   // several rays per beam, which sample its footprint; else one, along its axis
  // Most returns of a beam by severalHits or footprints; bounds the size of scans.
  std::uint32_t mostReturns = 1;
  // Rays may start anywhere, not only at the sensor, and so can continue through glass and off mirrors
  // (methods/interface/light_paths.h); else every surface stops them, except where alpha cuts it out.
  bool transmission = false;
  bool motion = false;     // the sensor may move during a revolution; else it stands still
  bool moving = false;     // objects may move, also during a revolution; else scenes with moving objects are refused
  bool passes = false;     // renders images that can be saved, see Method::depthCamera()
  bool reference = false;  // with default options exact enough to judge other methods by
  bool openGl = false;     // uses OpenGL, or may: a graphics card changes its speed
};

struct MethodEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view keys;  // the options: "name: default, what it is; ..."
  MethodCapabilities can;
  std::array<std::uint8_t, 3> color;  // sRGB, of its points in pictures that compare methods
  // The settings that `method: auto` tries if the pipeline names none: a YAML list as readSettings() takes it
  // (evaluate/settings.h).
  std::string_view autoSettings;
  // `options` is the map of the method in the pipeline; the maker calls its finish(). The scene must outlive the
  // method.
  std::unique_ptr<Method> (*make)(const Scene& scene, Fields& options);
};

}  // namespace scanmill
