#include <fmt/format.h>

#include "assets/worlds/sdf_parts.h"
#include "assets/worlds/solids.h"

namespace scanmill {
namespace {

constexpr std::size_t kLongestChain = 1000;  // of frames, each relative to the next

}  // namespace

bool isSdfTrue(const std::string& text) {
  return text == "true" || text == "True" || text == "TRUE" || text == "1";
}

SdfPose readSdfPose(const XmlNode& of) {
  const XmlNode* const element = of.child("pose");
  if (element == nullptr) return {};
  SdfPose read;
  read.relativeTo = element->attributeOr("relative_to", element->attributeOr("frame", ""));
  if (element->text.empty()) return read;
  const std::string format = element->attributeOr("rotation_format", "euler_rpy");
  if (format == "quat_xyzw") {
    const std::vector<double> n = numbersIn(*element, element->text, 7);
    read.pose = {rotationOf(*element, {n[6], n[3], n[4], n[5]}), {n[0], n[1], n[2]}};
    return read;
  }
  if (format != "euler_rpy") {
    element->fail(fmt::format("has the rotation_format '{}', but it must be euler_rpy or quat_xyzw", format));
  }
  const std::vector<double> n = numbersIn(*element, element->text, 6);
  const double unit = isSdfTrue(element->attributeOr("degrees", "false")) ? kPi / 180 : 1;
  read.pose = {fromYawPitchRoll(n[5] * unit, n[4] * unit, n[3] * unit), {n[0], n[1], n[2]}};
  return read;
}

void SdfFrames::add(const std::string& name, const Frame& frame) {
  const auto known = byName.find(name);
  const bool isLink = known != byName.end() && known->second.node->name == "link";
  if (isLink && frame.node->name == "link") {
    frame.node->fail(fmt::format("has the name '{}', as another link: links need names of their own", name));
  }
  if (!isLink) byName[name] = frame;
}

Pose SdfFrames::resolve(const std::string& name, const XmlNode& from) const {
  std::set<std::pair<const SdfFrames*, std::string>> passed;
  return resolve(name, from, passed);
}

Pose SdfFrames::resolve(const std::string& name, const XmlNode& from,
                        std::set<std::pair<const SdfFrames*, std::string>>& passed) const {
  if (name.empty() || name == "__model__" || name == "__root__" || (isWorld && name == "world")) return {};
  if (!passed.emplace(this, name).second) {
    from.fail(fmt::format("has a pose relative to '{}', which is relative to itself", name));
  }
  if (passed.size() > kLongestChain)
    from.fail(fmt::format("has a pose relative to a chain of more than {} frames", kLongestChain));
  // Files that sdformat 1.7 flattened have frames with colons in their names.
  const std::size_t colons = byName.contains(name) ? std::string::npos : name.find("::");
  const auto found = byName.find(name.substr(0, colons));
  if (found == byName.end() && inPlaceOfMissing) return resolve(*inPlaceOfMissing, from, passed);
  if (found == byName.end()) from.fail(fmt::format("has a pose relative to '{}', but this frame does not exist", name));
  const Frame& frame = found->second;
  const Pose pose = resolve(frame.pose.relativeTo, *frame.node, passed) * frame.pose.pose;
  if (colons == std::string::npos) return pose;
  if (frame.inside == nullptr) from.fail(fmt::format("has a pose relative to '{}', which is not in a model", name));
  return pose * frame.inside->resolve(name.substr(colons + 2), from, passed);
}

}  // namespace scanmill
