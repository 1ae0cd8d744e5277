#pragma once

// Frames on all threads: several are made at a time, and one after the other is taken in order.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace scanmill {

// Calls make(frame) for the frames 0 to frames - 1 on any thread, at most `inFlight` of them before take(frame) has
// been called for the first, and take() in the order of the frames. Ends early once `stop` (or null) is set.
void numbersInOrder(std::uint32_t frames, std::size_t inFlight, const std::atomic<bool>* stop,
                    const std::function<void(std::uint32_t)>& make, const std::function<void(std::uint32_t)>& take);

// The same where make(frame) gives something that take(made) gets.
template <class Made, class Make, class Take>
void framesInOrder(std::uint32_t frames, std::size_t inFlight, const std::atomic<bool>* stop, const Make& make,
                   const Take& take) {
  // Both ends run in order: among the frames in flight, no two have the same slot.
  std::vector<std::unique_ptr<Made>> slots(inFlight);
  numbersInOrder(
      frames, inFlight, stop,
      [&](std::uint32_t frame) { slots[frame % inFlight] = std::make_unique<Made>(make(frame)); },
      [&](std::uint32_t frame) { take(*std::exchange(slots[frame % inFlight], nullptr)); });
}

}  // namespace scanmill
