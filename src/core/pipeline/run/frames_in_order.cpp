#include "pipeline/run/frames_in_order.h"

#include <tbb/parallel_pipeline.h>

#include "base/tsan_order.h"

namespace scanmill {

void numbersInOrder(std::uint32_t frames, std::size_t inFlight, const std::atomic<bool>* stop,
                    const std::function<void(std::uint32_t)>& make, const std::function<void(std::uint32_t)>& take) {
  std::uint32_t next = 0;
  TaskOrder begun;
  TaskOrder made;
  const TaskOrder::Wait forFirst(begun, begun);
  const TaskOrder::Wait forThird(begun, made);
  const auto number = [&](tbb::flow_control& control) -> std::uint32_t {
    if (next < frames && (stop == nullptr || !*stop)) return next++;
    control.stop();
    return 0;
  };
  const auto first = [&](tbb::flow_control& control) SCANMILL_UNWATCHED -> std::uint32_t {
    const TaskOrder::Task task(begun, begun);
    return number(control);
  };
  const auto second = [&](std::uint32_t frame) SCANMILL_UNWATCHED -> std::uint32_t {
    const TaskOrder::Task task(begun, made);
    make(frame);
    return frame;
  };
  const auto third = [&](std::uint32_t frame) SCANMILL_UNWATCHED {
    const TaskOrder::Task task(made, made);
    take(frame);
  };
  using Number = std::uint32_t;
  tbb::parallel_pipeline(inFlight, tbb::make_filter<void, Number>(tbb::filter_mode::serial_in_order, first) &
                                       tbb::make_filter<Number, Number>(tbb::filter_mode::parallel, second) &
                                       tbb::make_filter<Number, void>(tbb::filter_mode::serial_in_order, third));
}

}  // namespace scanmill
