#pragma once

// The vehicles that drive and park in a town, each built when it is first needed.

#include <optional>
#include <vector>

#include "town/placer.h"

namespace scanmill::town {

constexpr int kRoadCyclistForms = 3;  // number of forms of cyclists on roads; those on sidewalks have the next ones
constexpr double kMiddle = 0.4;       // m, least distance between a vehicle and the centre line

class Fleet {
 public:
  explicit Fleet(Placer& placer) : placer_(placer), cars_(kCars), trucks_(2) {}

  const Model& anyCar(Draw& draw) {
    const auto index = static_cast<std::size_t>(draw.below(kCars));
    // There are two cars of each form.
    const auto form = static_cast<models::CarForm>(static_cast<int>(index) % models::kCarForms);
    if (!cars_[index]) {
      cars_[index] = models::makeCar(placer_.builder, placer_.layout.seed, form, static_cast<int>(index));
    }
    return *cars_[index];
  }
  const Model& anyTruck(Draw& draw) {
    const int form = draw.below(static_cast<int>(trucks_.size()));
    std::optional<Model>& truck = trucks_[static_cast<std::size_t>(form)];
    if (!truck) truck = models::makeTruck(placer_.builder, placer_.layout.seed, form);
    return *truck;
  }
  const Model& bus() {
    if (!bus_) bus_ = models::makeBus(placer_.builder, placer_.layout.seed);
    return *bus_;
  }

 private:
  static constexpr int kCars = 2 * models::kCarForms;
  Placer& placer_;
  std::vector<std::optional<Model>> cars_, trucks_;
  std::optional<Model> bus_;
};

// Places the vehicles and cyclists that are driving.
void placeTraffic(Placer& placer, Fleet& fleet);

}  // namespace scanmill::town
