#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "assets/worlds/model_search.h"
#include "assets/worlds/solids.h"
#include "assets/worlds/world.h"
#include "assets/worlds/xml.h"

namespace scanmill {
namespace {

Affine readOrigin(const XmlNode& of) {
  const XmlNode* const origin = of.child("origin");
  if (origin == nullptr) return {};
  const Vec3d at = vectorIn(*origin, origin->attributeOr("xyz", "0 0 0"));
  const Vec3d turned = vectorIn(*origin, origin->attributeOr("rpy", "0 0 0"));
  return toAffine({fromYawPitchRoll(turned.z, turned.y, turned.x), at});
}

class UrdfReader {
 public:
  explicit UrdfReader(const std::filesystem::path& file) : file_(file), root_(readXml(file)) {}

  World read() {
    if (root_.name != "robot") root_.fail("is not a URDF: its first element must be <robot>");
    for (const XmlNode& child : root_.children) {
      if (child.name.starts_with("xacro:")) {
        child.fail("is a macro: expand the file first, by `xacro robot.urdf.xacro > robot.urdf`");
      }
      if (child.name == "material") noteMaterial(child);
      if (child.name == "joint") noteJoint(child);
    }
    for (const auto& [child, joint] : joints_) {
      for (const std::string& link : {child, joint.parent}) {
        const auto is = [&](const XmlNode& n) { return n.name == "link" && n.attributeOr("name", "link") == link; };
        if (std::none_of(root_.children.begin(), root_.children.end(), is)) {
          throw InputError(joint.where, fmt::format("<joint> names the link '{}', but this link does not exist", link));
        }
      }
    }
    const XmlNode* first = nullptr;
    for (const XmlNode& link : root_.children) {
      if (link.name != "link" || joints_.contains(link.attributeOr("name", "link"))) continue;
      if (first != nullptr) {
        link.fail(fmt::format("'{}' and '{}' are both the child of no joint, but only one link can be the root",
                              link.attributeOr("name", "link"), first->attributeOr("name", "link")));
      }
      first = &link;
    }
    WorldThing robot{root_.attributeOr("name", "robot"), {}, {}, {}};
    for (const XmlNode& link : root_.children) {
      if (link.name != "link") continue;
      const std::string name = link.attributeOr("name", "link");
      const Affine robotFromLink = placeOf(name, link);
      std::size_t number = 0;
      for (const XmlNode& visual : link.children) {
        if (visual.name == "visual") addVisual(visual, name, ++number, robotFromLink, robot.parts);
      }
    }
    world_.things.push_back(std::move(robot));
    return std::move(world_);
  }

 private:
  struct Joint {
    std::string parent;
    Affine parentFromChild;
    Location where;
  };

  void noteJoint(const XmlNode& joint) {
    const auto linkOf = [&](const char* end) {
      const XmlNode* const element = joint.child(end);
      const std::string* const link = element == nullptr ? nullptr : element->attribute("link");
      if (link == nullptr) joint.fail(fmt::format("has no <{} link=\"...\">", end));
      return *link;
    };
    if (!joints_.try_emplace(linkOf("child"), Joint{linkOf("parent"), readOrigin(joint), joint.where}).second) {
      joint.fail(fmt::format("gives the link '{}' a second parent joint", linkOf("child")));
    }
  }

  struct Look {
    std::optional<std::array<float, 3>> color;
    std::filesystem::path texture;
  };

  // Returns the look of a material element. An element without a look refers by its name to an earlier element.
  Look noteMaterial(const XmlNode& material) {
    Look look;
    if (const XmlNode* color = material.child("color")) look.color = colorOf(*color, color->attributeOr("rgba", ""));
    if (const XmlNode* texture = material.child("texture")) {
      try {
        look.texture = findModel(*texture, file_, texture->attributeOr("filename", ""));
      } catch (const InputError&) {
        world_.leftOut.push_back(fmt::format("the missing texture '{}'", texture->attributeOr("filename", "")));
      }
    }
    const std::string name = material.attributeOr("name", "");
    if (name.empty()) return look;
    if (look.color || !look.texture.empty()) looks_[name] = look;
    const auto known = looks_.find(name);
    return known == looks_.end() ? look : known->second;
  }

  // Returns robotFromLink. The robot's frame is the frame of its root link.
  Affine placeOf(std::string name, const XmlNode& link) const {
    Affine place;
    std::set<std::string> been;
    for (auto joint = joints_.find(name); joint != joints_.end(); joint = joints_.find(name)) {
      if (!been.insert(name).second) link.fail(fmt::format("'{}' is its own ancestor by the joints", name));
      place = joint->second.parentFromChild * place;
      name = joint->second.parent;
    }
    return place;
  }

  void addVisual(const XmlNode& visual, const std::string& link, std::size_t number, const Affine& robotFromLink,
                 std::vector<WorldPart>& parts) {
    const XmlNode* const geometry = visual.child("geometry");
    if (geometry == nullptr || geometry->children.empty()) return;
    const XmlNode& shape = geometry->children.front();
    WorldPart part;
    part.where = visual.where;
    part.node = link + "/" + visual.attributeOr("name", fmt::format("visual_{}", number));
    part.thingFromPart = robotFromLink * readOrigin(visual);
    if (shape.name == "mesh") {
      part.mesh = findModel(shape, file_, shape.attributeOr("filename", ""));
      part.thingFromPart.linear =
          part.thingFromPart.linear * Mat3::scale(vectorIn(shape, shape.attributeOr("scale", "1 1 1")));
    } else {
      part.solid = solidOf(shape);
      if (!part.solid) shape.fail("is not a shape of URDF (mesh, box, cylinder or sphere)");
    }
    if (const XmlNode* material = visual.child("material")) {
      const Look look = noteMaterial(*material);
      part.material = material->attributeOr("name", "");
      part.color = look.color;
      part.texture = look.texture;
    }
    parts.push_back(std::move(part));
  }

  std::filesystem::path file_;
  XmlNode root_;
  std::map<std::string, Joint> joints_;  // joints, by name of their child link
  std::map<std::string, Look> looks_;
  World world_;
};

}  // namespace

World readUrdf(const std::filesystem::path& file) {
  return UrdfReader(file).read();
}

}  // namespace scanmill
