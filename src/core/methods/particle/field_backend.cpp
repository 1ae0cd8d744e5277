#include "methods/particle/field_backend.h"

#include <fmt/core.h>

#include <algorithm>
#include <new>
#include <utility>

#include "base/error.h"
#include "base/wall_timer.h"
#include "gpu/device.h"
#include "methods/field/build.h"
#include "methods/field/same_field.h"

namespace scanmill {

using Fields = std::vector<std::shared_ptr<const DistanceField>>;

FieldBackend::FieldBackend(std::unique_ptr<DeviceBricks> device) : device_(std::move(device)) {
  states_.fill(device_ != nullptr ? State::Open : State::Processor);
}

std::shared_ptr<const DistanceField> FieldBackend::build(const std::shared_ptr<const World>& world,
                                                         const FieldShape& shape, const Fields& before) {
  std::unique_lock lock(building_);
  State& state = states_[shape.lists ? 1 : 0];
  if (state == State::Processor || world->baked.triangles.empty()) {
    lock.unlock();
    return buildField(*world, shape, before);
  }
  std::string failed;
  std::shared_ptr<const DistanceField> there;
  double onDevice = 0;
  try {
    there = byDevice(world, shape, before, onDevice);
    if (state == State::Device) return there;
  } catch (const Error& error) {
    failed = error.what();
  } catch (const std::bad_alloc&) {
    failed = "memory is out";
  }
  std::shared_ptr<const DistanceField> here;
  // What is wrong with the field itself is thrown here, too, and says nothing of the device.
  const double onProcessor = secondsOf([&] { here = buildField(*world, shape, before); });
  if (failed.empty() && !sameField(*there, *here)) failed = "the device does not keep IEEE 754";
  if (!failed.empty()) {
    warn(fmt::format("fields are built on the processor: {}", failed));
    tell(shape.lists, fmt::format("the processor, since {} had failed", device_->device()));
    state = State::Processor;
  } else if (!here->distance.empty()) {
    state = chosen(onDevice, onProcessor, shape.lists);
  }
  return here;
}

FieldBackend::State FieldBackend::chosen(double onDevice, double onProcessor, bool lists) {
  const bool faster = onDevice < onProcessor;
  const std::string device = device_->device();
  tell(lists, fmt::format("{} ({:.0f} ms a field; {} {:.0f} ms)", faster ? device : "the processor",
                          1e3 * std::min(onDevice, onProcessor), faster ? "the processor" : device,
                          1e3 * std::max(onDevice, onProcessor)));
  return faster ? State::Device : State::Processor;
}

// The seconds are those of building alone: the scene is brought there once.
std::shared_ptr<const DistanceField> FieldBackend::byDevice(const std::shared_ptr<const World>& world,
                                                            const FieldShape& shape, const Fields& before,
                                                            double& seconds) {
  device_->hold(world);
  const WallTimer timer;
  auto made = buildField(*world, shape, before, device_.get());
  seconds = timer.seconds();
  return made;
}

void FieldBackend::tell(bool lists, std::string outcome) {
  const std::scoped_lock lock(telling_);
  outcomes_[lists ? 1 : 0] = std::move(outcome);
}

std::string FieldBackend::outcome(bool lists) const {
  const std::scoped_lock lock(telling_);
  return outcomes_[lists ? 1 : 0];
}

std::unique_ptr<DeviceBricks> findDeviceBricks() {
  if (!mayHaveCard()) return nullptr;
  try {
    auto device = std::make_unique<DeviceBricks>();
    return device->software() ? nullptr : std::move(device);
  } catch (const Error&) {
    return nullptr;  // who flies the particles tells why
  }
}

}  // namespace scanmill
