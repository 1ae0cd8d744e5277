#include "methods/particle/field_backend.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/wall_timer.h"
#include "gpu/device.h"
#include "methods/field/build.h"
#include "methods/field/same_field.h"

namespace scanmill {

using Fields = std::vector<std::shared_ptr<const DistanceField>>;

FieldBackend::FieldBackend(std::unique_ptr<DeviceBricks> device)
    : device_(std::move(device)), open_(device_ != nullptr) {}

std::shared_ptr<const DistanceField> FieldBackend::build(const std::shared_ptr<const World>& world,
                                                         const FieldShape& shape, const Fields& before) {
  std::unique_lock lock(building_);
  const bool first = std::exchange(open_, false);
  if (!first && !taken_) {
    lock.unlock();
    return buildField(*world, shape, before);
  }
  double there = 0;
  double here = 0;
  try {
    auto made = byDevice(world, shape, before, there);
    if (taken_) return made;
    std::shared_ptr<const DistanceField> known;
    here = secondsOf([&] { known = buildField(*world, shape, before); });
    if (!sameField(*made, *known)) throw Error("the device does not keep IEEE 754");
    taken_ = there < here;
    const std::string device = device_->device();
    outcome_ =
        fmt::format("{} ({:.0f} ms a field; {} {:.0f} ms)", taken_ ? device : "the processor",
                    1e3 * (taken_ ? there : here), taken_ ? "the processor" : device, 1e3 * (taken_ ? here : there));
    return known;
  } catch (const Error& error) {
    giveUp(error.what());
  }
  lock.unlock();
  return buildField(*world, shape, before);
}

// The seconds are those of building alone: the scene is brought there once.
std::shared_ptr<const DistanceField> FieldBackend::byDevice(const std::shared_ptr<const World>& world,
                                                            const FieldShape& shape, const Fields& before,
                                                            double& seconds) {
  if (!world->baked.triangles.empty()) device_->hold(world);
  const WallTimer timer;
  auto made = buildField(*world, shape, before, device_.get());
  seconds = timer.seconds();
  return made;
}

void FieldBackend::giveUp(const std::string& why) {
  warn(fmt::format("fields are built on the processor: {}", why));
  taken_ = false;
  tell(fmt::format("the processor, since {} had failed", device_->device()));
}

void FieldBackend::tell(std::string outcome) {
  const std::scoped_lock lock(telling_);
  outcome_ = std::move(outcome);
}

std::string FieldBackend::outcome() const {
  const std::scoped_lock lock(telling_);
  return outcome_;
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
