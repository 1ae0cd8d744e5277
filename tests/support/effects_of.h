#pragma once

#include "sense/effect.h"

namespace scanmill {

// The effects of a list such as "[{intensity: {}}, {range_noise: {sigma_m: 0.02}}]", in its order.
inline Effects effectsOf(const Value& list) {
  Effects made;
  for (const Value& item : list.items) {
    const auto& [name, value] = item.entries.front();
    Fields options(value, "effect " + name);
    const EffectEntry& entry = requireEffect(name, item.where);
    made.push_back({&entry, entry.make(options), {}});
  }
  return made;
}

}  // namespace scanmill
