#pragma once

// A list of the features of the world and of its sensors that a dataset models or leaves out. `scanmill plan` prints
// the items, the manifest stores them.
//
//   for (const ModelledItem& item : readManifest("out/quickstart").modelled) std::puts(item.topic.c_str());

#include <cstdint>
#include <string>
#include <vector>

namespace scanmill {

struct ModelledItem {
  std::string topic;  // "geometry", "effect speckle"
  std::string text;   // how it is modelled, or why it is left out; without counts that differ between scenes
  bool leftOut = false;
  std::string sensor = {};               // name of the sensor that the item is about; empty: all sensors
  std::string options = {};              // options of an effect, as YAML on one line
  std::vector<std::string> scenes = {};  // scenes with their seeds, such as "street-s1"; empty: all scenes
  std::uint64_t parts = 0;               // largest number of a scene's parts that the item is about; 0: not about parts

  bool operator==(const ModelledItem&) const = default;
};

// Returns an item without its scenes as one line, such as "voxels: left out (`output.voxels: true` adds ...)".
std::string lineOf(const ModelledItem& item);

// Adds items to a list. Items that differ only in their scenes become one item about all these scenes.
void addItems(const std::vector<ModelledItem>& added, std::vector<ModelledItem>& items);

}  // namespace scanmill
