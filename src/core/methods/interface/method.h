#pragma once

// What a method is: it turns a shot into Hits. Adding one is a new file and a row in methods() (methods/method.h).

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

// All calls are safe from several threads at once. Nothing that a method keeps from call to call changes a result: it
// keeps what it would otherwise make again, such as the hierarchy around a sensor.
class Method {
 public:
  virtual ~Method() = default;
  // Does now what trace() would do first for a shot at such a place, such as building a hierarchy, so that set-up and
  // tracing can be timed apart. Never needed for the result.
  virtual TraceAccount prepare(const Shot& shot) const = 0;
  // Fills `hits` with the channels asked for; the result depends on the shot alone. A hit nearer than the sensor's
  // minimum range, or farther than its maximum, is a miss.
  virtual TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const = 0;
  // What it models of the scene and what it leaves out, one line each, for `plan` and the manifest.
  virtual std::vector<std::string> modelled() const = 0;
  // Of the scene's own meshes and of all that the method keeps besides, as far as both are loaded now: what `plan`
  // says.
  virtual std::uint64_t memoryBytes() const = 0;
  // Itself, where it draws passes that can be kept (MethodCapabilities::passes); else null.
  virtual const DepthCamera* depthCamera() const { return nullptr; }
  // Its hierarchies of the scene's own triangles, with thingFilter() (methods/ray_tracing/unobstructed.h) for
  // occlusions, where it has such that others may share; else null.
  virtual const Worlds* worlds() const { return nullptr; }
};

// What a method can do. The plan refuses a pipeline that asks for more.
struct MethodCapabilities {
  bool severalHits = false;  // several hits along a ray, one behind the other; else the first alone
  bool footprints = false;   // several rays a beam, which sample its footprint; else one, along its axis
  // Returns that a beam may have by either of the two: bounds what scans take.
  std::uint32_t mostReturns = 1;
  // Rays start anywhere, not only at the sensor, and so go on behind glass and off mirrors
  // (methods/interface/light_paths.h); else whatever is not cut out by alpha stops them.
  bool transmission = false;
  bool motion = false;     // the sensor's pose changes during a revolution; else it stands still meanwhile
  bool moving = false;     // objects of the scene move, during a revolution too; else it refuses scenes that do
  bool passes = false;     // it draws images that can be kept, see Method::depthCamera()
  bool reference = false;  // with default options it is exact enough to judge other methods by
  bool openGl = false;     // it draws or computes by OpenGL, or may: a graphics card changes its speed
};

struct MethodEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view keys;  // of its options, "name: default, what it is; ..."
  MethodCapabilities can;
  std::array<std::uint8_t, 3> color;  // sRGB, of its points in pictures that tell methods apart
  // Those of its settings that `method: auto` chooses from where the pipeline names none: a YAML list as readSettings()
  // takes it (evaluate/settings.h).
  std::string_view autoSettings;
  // `options` is the method's own map in the pipeline; finish() is called by the maker. The scene must outlive it.
  std::unique_ptr<Method> (*make)(const Scene& scene, Fields& options);
};

}  // namespace scanmill
