#pragma once

// Who builds fields: the processor, or a graphics card.

#include <array>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "methods/field/device_bricks.h"
#include "methods/field/distance_field.h"
#include "methods/world/world.h"

namespace scanmill {

class FieldBackend {
 public:
  // Without a device the processor builds all.
  explicit FieldBackend(std::unique_ptr<DeviceBricks> device);

  // What buildField() gives (methods/field/build.h). The first field that has full bricks is built on both, with lists
  // and without, and who is faster builds the next. A device that fails, or that gives another field, is not taken:
  // then it warns, and the processor takes over. Safe to call from several threads.
  std::shared_ptr<const DistanceField> build(const std::shared_ptr<const World>& world, const FieldShape& shape,
                                             const std::vector<std::shared_ptr<const DistanceField>>& before);

  // Of fields with lists or without, for the summary of a run: "llvmpipe (51 ms a field; the processor 214 ms)"; empty
  // where there is no device, or where nothing was built yet.
  std::string outcome(bool lists) const;

 private:
  std::shared_ptr<const DistanceField> byDevice(const std::shared_ptr<const World>& world, const FieldShape& shape,
                                                const std::vector<std::shared_ptr<const DistanceField>>& before,
                                                double& seconds);

  enum class State { Open, Processor, Device };
  State chosen(double onDevice, double onProcessor, bool lists);  // s that a field takes
  void tell(bool lists, std::string outcome);

  std::mutex building_;  // of what follows, and held while the device builds
  const std::unique_ptr<DeviceBricks> device_;
  std::array<State, 2> states_;  // of fields without lists, and with
  mutable std::mutex telling_;
  std::array<std::string, 2> outcomes_;
};

// A device that may build fields faster than the processor does: a graphics card, where the machine has one that works.
// OpenGL on the processor is none. Null: there is none.
std::unique_ptr<DeviceBricks> findDeviceBricks();

}  // namespace scanmill
