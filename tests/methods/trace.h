#pragma once

#include <memory>
#include <string>

#include "config/fields.h"
#include "methods/method.h"

namespace scanmill {

// Ray tracing with options such as "{packet: 1}".
inline std::unique_ptr<Method> rayTracing(const Scene& scene, const std::string& options = "{}") {
  const Value value = parseYaml(options, "options");
  Fields fields(value, "method ray_tracing");
  return requireMethod("ray_tracing", {}).make(scene, fields);
}

inline Hits traced(const Method& method, const Shot& shot, Channels channels = Channels::all()) {
  Hits hits;
  method.trace(shot, channels, hits);
  return hits;
}

inline Hits traced(const Scene& scene, const Shot& shot, const std::string& options = "{}") {
  return traced(*rayTracing(scene, options), shot);
}

}  // namespace scanmill
