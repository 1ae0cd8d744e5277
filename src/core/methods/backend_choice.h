#pragma once

// Whether a method's shots are traced on the processor or on a device of OpenGL, where it can do both.

#include <atomic>
#include <functional>
#include <string>

#include "base/stage_clock.h"
#include "scan/hits.h"

namespace scanmill {

class BackendChoice {
 public:
  enum class Asked { Auto, Cpu, Gl };  // by the pipeline
  // Makes the hits of a shot anew, and adds its stages to the clock.
  using Way = std::function<void(Hits&, StageClock&)>;

  // `device`: there is one. `doing`: "rays are traced", for warnings.
  BackendChoice(Asked asked, bool device, std::string doing);

  // Traces a shot. Where it is open which way is faster, the first caller goes both, twice each, since the first time
  // uploads the scene, and adds "backend_choice" to the clock; callers that come meanwhile take the processor, as they
  // would beside later ones. A device that finds other hits than the processor is not taken, so that scans do not
  // depend on what was chosen, nor, unless it was asked for, one that fails: then it warns, and the processor takes
  // over.
  void trace(const Way& onDevice, const Way& onProcessor, Hits& hits, StageClock& clock);

 private:
  enum class State { Open, Choosing, Processor, Device };
  State faster(const Way& onDevice, const Way& onProcessor) const;

  const Asked asked_;
  const std::string doing_;
  std::atomic<State> state_;
};

}  // namespace scanmill
