#pragma once

// The methods that there are. Each turns a shot into Hits:
//
//   const std::unique_ptr<Method> method = makeReference(scene);
//   Hits hits;
//   method->trace(shot, Channel::Range | Channel::Semantic, hits);

#include <memory>
#include <span>
#include <string_view>

#include "config/value.h"
#include "methods/interface/method.h"
#include "scene/scene.h"

namespace scanmill {

std::span<const MethodEntry> methods();
// Returns the method of this name. Throws InputError with the names that there are, `other` among them, if there is
// none.
const MethodEntry& requireMethod(std::string_view name, const Location& where, std::string_view other = {});
// Null where no row has this name.
const MethodEntry* findMethod(std::string_view name);
// The first row that can do such a thing. Only for what some row can do.
const MethodEntry& firstMethodThat(bool MethodCapabilities::*can);
// The method that judges others and looks at scenes before they are scanned, with default options.
std::unique_ptr<Method> makeReference(const Scene& scene);

}  // namespace scanmill
