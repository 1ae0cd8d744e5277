#include "methods/backend_choice.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace scanmill {

BackendChoice::BackendChoice(Asked asked, bool device, std::string doing)
    : asked_(asked),
      doing_(std::move(doing)),
      state_(!device                ? State::Processor
             : asked == Asked::Auto ? State::Open
                                    : State::Device) {}

void BackendChoice::trace(const Way& onDevice, const Way& onProcessor, Hits& hits, StageClock& clock) {
  State open = State::Open;
  if (state_.compare_exchange_strong(open, State::Choosing)) {
    const StageTimer timer(clock, "backend_choice");
    state_ = faster(onDevice, onProcessor);
  }
  if (state_ == State::Device) {
    try {
      return onDevice(hits, clock);
    } catch (const Error& error) {
      if (asked_ != Asked::Auto) throw;
      warn(fmt::format("{} on the processor: {}", doing_, error.what()));
      state_ = State::Processor;
    }
  }
  onProcessor(hits, clock);
}

BackendChoice::State BackendChoice::faster(const Way& onDevice, const Way& onProcessor) const {
  double device = INFINITY;
  double processor = INFINITY;
  StageClock ignored;
  try {
    for (int round = 0; round < 2; ++round) {
      Hits there;
      Hits here;
      device = std::min(device, secondsOf([&] { onDevice(there, ignored); }));
      processor = std::min(processor, secondsOf([&] { onProcessor(here, ignored); }));
      if (there.range != here.range || there.instance != here.instance || there.primitive != here.primitive) {
        throw Error("the device does not keep IEEE 754");
      }
    }
  } catch (const Error& error) {
    warn(fmt::format("{} on the processor: {}", doing_, error.what()));
    return State::Processor;
  }
  return device < processor ? State::Device : State::Processor;
}

}  // namespace scanmill
