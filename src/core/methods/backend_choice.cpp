#include "methods/backend_choice.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace scanmill {

BackendChoice::BackendChoice(Asked asked, std::string device, std::string doing)
    : asked_(asked),
      device_(std::move(device)),
      doing_(std::move(doing)),
      state_(device_.empty()        ? State::Processor
             : asked == Asked::Auto ? State::Open
                                    : State::Device),
      outcome_(state_ == State::Device ? device_ : std::string()) {}

void BackendChoice::trace(std::size_t rays, const Way& onDevice, const Way& onProcessor, Hits& hits,
                          StageClock& clock) {
  if (rays < kFewRays) return onProcessor(hits, clock);
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
      tell(fmt::format("the processor, after {} had failed", device_));
      state_ = State::Processor;
    }
  }
  onProcessor(hits, clock);
}

std::string BackendChoice::outcome() const {
  const std::scoped_lock lock(mutex_);
  return outcome_;
}

void BackendChoice::tell(std::string outcome) {
  const std::scoped_lock lock(mutex_);
  outcome_ = std::move(outcome);
}

BackendChoice::State BackendChoice::faster(const Way& onDevice, const Way& onProcessor) {
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
    tell(fmt::format("the processor, since {} had failed", device_));
    return State::Processor;
  }
  const bool faster = device < processor;
  tell(fmt::format("{} ({:.1f} ms a scan; {} {:.1f} ms)", faster ? device_ : "the processor",
                   1e3 * std::min(device, processor), faster ? "the processor" : device_,
                   1e3 * std::max(device, processor)));
  return faster ? State::Device : State::Processor;
}

}  // namespace scanmill
