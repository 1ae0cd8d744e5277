#pragma once

// The list of methods. Each turns a shot into Hits:
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
// Returns the method with this name. If no method has the name, throws InputError at `where`, with a suggestion.
const MethodEntry& requireMethod(std::string_view name, const Location& where);
// Returns the method with this name; null if no method has the name.
const MethodEntry* findMethod(std::string_view name);
// Returns the first entry of methods() with the capability `can`. At least one method must have this capability.
const MethodEntry& firstMethodThat(bool MethodCapabilities::*can);
// Returns the reference method with default options. The accuracy of other methods is measured against it, and scenes
// are inspected with it before they are scanned.
std::unique_ptr<Method> makeReference(const Scene& scene);

}  // namespace scanmill
