#pragma once

// Whether a method's shots are traced on the processor or on a device of OpenGL, where it can do both.

#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>

#include "base/stage_clock.h"
#include "scan/hits.h"

namespace scanmill {

class BackendChoice {
 public:
  enum class Asked { Auto, Cpu, Gl };  // by the pipeline
  // Makes the hits of a shot anew, and adds its stages to the clock.
  using Way = std::function<void(Hits&, StageClock&)>;

  // Shots of fewer rays, such as those that look at a scene before it is scanned, are the processor's: asking a device
  // takes longer.
  static constexpr std::size_t kFewRays = 512;

  // `device`: its name; empty: there is none. `doing`: "rays are traced", for warnings.
  BackendChoice(Asked asked, std::string device, std::string doing);

  // Traces a shot of so many rays. Where it is open which way is faster, the first caller goes both, twice each, since
  // the first time uploads the scene, and adds "backend_choice" to the clock; callers that come meanwhile take the
  // processor, as they would beside later ones. A device that finds other hits than the processor is not taken, so that
  // scans do not depend on what was chosen, nor, unless it was asked for, one that fails: then it warns, and the
  // processor takes over.
  void trace(std::size_t rays, const Way& onDevice, const Way& onProcessor, Hits& hits, StageClock& clock);

  // Who takes the shots, for the summary of a run: "llvmpipe (2.1 ms a scan; the processor 6.3 ms)"; empty where there
  // is no device, or where nothing was chosen yet.
  std::string outcome() const;

 private:
  enum class State { Open, Choosing, Processor, Device };
  State faster(const Way& onDevice, const Way& onProcessor);
  void tell(std::string outcome);

  const Asked asked_;
  const std::string device_;
  const std::string doing_;
  std::atomic<State> state_;
  mutable std::mutex mutex_;
  std::string outcome_;
};

}  // namespace scanmill
