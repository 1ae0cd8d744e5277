#pragma once

// The interface of a method, which turns a shot into Hits. To add a method, add a file and a row in methods()
// (methods/method.h). This header is installed because methods/method.h includes it.
//
//   const Value defaults;
//   Fields options(defaults, "particle");
//   const std::unique_ptr<Method> method = requireMethod("particle", {}).make(scene, options);

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/stage_clock.h"
#include "config/fields.h"
#include "scan/channels.h"
#include "scan/hits.h"
#include "scan/modelled_item.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// A problem of some beams of a scan, which makes these beams less accurate than the user expects.
struct BeamWarning {
  std::string sensor;       // name of the sensor
  unsigned kind = 0;        // number of the warning within its method; a sensor's warnings are reported in this order
  std::uint64_t count = 0;  // number of the scan's beams with the problem
  std::string text;         // the complete sentence for the user, with count, sensor and remedy
};

struct TraceAccount {
  StageSeconds seconds;               // seconds of each stage; empty if the method has only one stage
  std::vector<BeamWarning> warnings;  // at most one per sensor and kind, ordered by sensor and then kind

  // Adds a warning. Of two warnings with the same sensor and kind, only the one with more beams is kept: a user is
  // interested in the worst scan, and the order in which scans are traced must not change the report.
  void warn(BeamWarning warning);
  // Adds the seconds and the warnings of `other`.
  TraceAccount& operator+=(const TraceAccount& other);
  std::vector<std::string> warningTexts() const;
};

class DepthCamera;
class Worlds;

// All member functions may be called from several threads at once. A method may cache data between calls, such as the
// hierarchy around a sensor; a cache never changes a result.
class Method {
 public:
  virtual ~Method() = default;
  // Builds what trace() needs for this shot, such as a hierarchy around the sensor; otherwise trace() builds it. Allows
  // preparation and tracing to be timed separately. Never changes a result.
  virtual TraceAccount prepare(const Shot& shot) const = 0;
  // Fills `hits` with the requested channels; the result depends only on the shot. A hit nearer than the sensor's
  // minimum range or farther than its maximum range is a miss.
  virtual TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const = 0;
  // Returns which features of the scene the method models and which it leaves out, for `plan` and the manifest.
  virtual std::vector<ModelledItem> modelled() const = 0;
  // Returns approximately how many bytes the scene's loaded meshes and the method's caches take now, for `plan`.
  virtual std::uint64_t memoryBytes() const = 0;
  // Returns this method if it renders passes that can be saved (MethodCapabilities::passes), otherwise null.
  virtual const DepthCamera* depthCamera() const { return nullptr; }
  // Returns the method's hierarchies of the scene's triangles, whose occlusion filter must be thingFilter()
  // (methods/ray_tracing/unobstructed.h), for use by other code; null if the method has no hierarchies to share.
  virtual const Worlds* worlds() const { return nullptr; }
};

constexpr std::uint64_t kBytesPerSceneTriangle = 40;  // memory of the scene itself, measured

// Return the items of Method::modelled() for the alpha cut-outs and the textures of a scene's materials.
ModelledItem cutOutItem(const Scene& scene);
ModelledItem textureItem(const Scene& scene);

// The capabilities of a method. The plan refuses a pipeline that needs a capability which its method lacks.
struct MethodCapabilities {
  // True if rays can start anywhere, not only at the sensor, and therefore can continue through glass and off mirrors
  // (methods/interface/light_paths.h). False: every surface stops rays, except where alpha cuts the surface out.
  bool transmission = false;
  bool moving = false;     // objects may move, also during a revolution; false: scenes with moving objects are refused
  bool passes = false;     // renders images that can be saved: see Method::depthCamera()
  bool reference = false;  // exact enough, with default options, to be the reference for other methods
  bool openGl = false;     // uses OpenGL, at least with some options: its speed then depends on the graphics card
};

struct MethodEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view keys;  // the options, a line for each: "name: default, meaning"
  MethodCapabilities can;
  std::array<std::uint8_t, 3> color;  // sRGB, colour of the method's points in pictures that compare methods
  // Creates a method from its map in the pipeline, and calls options.finish(). The scene must outlive the method.
  std::unique_ptr<Method> (*make)(const Scene& scene, Fields& options);
};

}  // namespace scanmill
