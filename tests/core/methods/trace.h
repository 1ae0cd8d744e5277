#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "methods/method.h"
#include "tests/support/on_threads.h"

namespace scanmill {

// A method with options such as "{instancing: never}".
inline std::unique_ptr<Method> methodOf(std::string_view name, const Scene& scene, const std::string& options = "{}") {
  const Value value = parseYaml(options, "options");
  Fields fields(value, "method " + std::string(name));
  return requireMethod(name, {}).make(scene, fields);
}

inline std::unique_ptr<Method> rayTracing(const Scene& scene, const std::string& options = "{}") {
  return methodOf("ray_tracing", scene, options);
}

inline Hits traced(const Method& method, const Shot& shot, Channels channels = Channels::all()) {
  Hits hits;
  method.trace(shot, channels, hits);
  return hits;
}

inline Hits traced(const Scene& scene, const Shot& shot, const std::string& options = "{}") {
  return traced(*rayTracing(scene, options), shot);
}

// Shots that eight threads trace at once.
inline std::vector<Hits> tracedByThreads(const Method& method, std::size_t shots,
                                         const std::function<Shot(std::size_t)>& shotOf) {
  constexpr std::size_t kThreads = 8;
  std::vector<Hits> made(shots);
  onThreads(kThreads, [&](std::size_t thread) {
    for (std::size_t i = thread; i < shots; i += kThreads) made[i] = traced(method, shotOf(i));
  });
  return made;
}

}  // namespace scanmill
