#pragma once

// A method turns a shot into Hits. Adding one is a new file and a row in methods().

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "config/fields.h"
#include "scan/channels.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

class Method {
 public:
  virtual ~Method() = default;
  // Does now what trace() would do first for a shot at such a place, such as building a hierarchy, so that set-up and
  // tracing can be timed apart. Never needed for the result.
  virtual void prepare(const Shot& shot) const = 0;
  // Fills `hits` with the channels asked for. Safe to call from several threads at once; the result depends on the
  // shot alone. A hit nearer than the sensor's minimum range, or farther than its maximum, is a miss.
  virtual void trace(const Shot& shot, Channels channels, Hits& hits) const = 0;
  // What it models of the scene and what it leaves out, one line each, for `plan` and the manifest.
  virtual std::vector<std::string> modelled() const = 0;
  virtual std::uint64_t memoryBytes() const = 0;
  // Seconds of trace() so far, summed over threads, by the method's own stages; empty: it has but one.
  virtual std::map<std::string, double> stageSeconds() const { return {}; }
  // What its user should know of the shots so far, such as beams that it cannot see.
  virtual std::vector<std::string> warnings() const { return {}; }
};

struct MethodEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view keys;  // of its options, "name: default, what it is; ..."
  // `options` is the method's own map in the pipeline; finish() is called by the maker. The scene must outlive it.
  std::unique_ptr<Method> (*make)(const Scene& scene, Fields& options);
};

std::span<const MethodEntry> methods();
const MethodEntry& requireMethod(std::string_view name, const Location& where);

}  // namespace scanmill
