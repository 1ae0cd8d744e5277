#pragma once

// Parts of the reader of SDF: poses relative to named frames, and the visuals of links.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "assets/worlds/world_asset.h"
#include "assets/worlds/xml.h"

namespace scanmill {

struct SdfPose {
  Pose pose;
  std::string relativeTo;  // frame of `pose`; empty: the frame of the world, model or link around it
};

// Returns the <pose> of an element; the identity if it has none.
SdfPose readSdfPose(const XmlNode& owner);

bool isSdfTrue(const std::string& text);

// The named frames of a world or a model, to which poses may be relative.
class SdfFrames {
 public:
  struct Frame {
    const XmlNode* node = nullptr;
    SdfPose pose;
    std::shared_ptr<const SdfFrames> inside;  // frames inside a model; null: this frame is not a model
  };
  std::map<std::string, Frame> byName;
  bool isWorld = false;
  // Set if a file with frames is missing: the name of the frame that stands in for all frames that `byName` lacks.
  std::optional<std::string> substitute;

  // Adds a frame. If a joint, frame or model has the name of a link, which SDF 1.6 allows, the name means the link.
  void add(const std::string& name, const Frame& frame);

  // Returns the pose of a frame in the frame of the world or model. `from`: the element in error messages.
  Pose resolve(const std::string& name, const XmlNode& from) const;

 private:
  // `visited`: the frames whose poses are being resolved because they depend on this frame.
  Pose resolve(const std::string& name, const XmlNode& from,
               std::set<std::pair<const SdfFrames*, std::string>>& visited) const;
};

// The link that contains a visual.
struct SdfLink {
  std::string name;
  Pose modelFromLink;
  const SdfFrames& frames;            // frames of the model
  const std::filesystem::path& file;  // the model's file
  Vec3d scale{1, 1, 1};               // scale of the model in the world's state
};

// Returns the visual as a part of the model; nullopt if it shows nothing. Adds what is left out or missing to `world`.
std::optional<WorldPart> readSdfVisual(const XmlNode& visual, const SdfLink& link, WorldFile& world);

}  // namespace scanmill
