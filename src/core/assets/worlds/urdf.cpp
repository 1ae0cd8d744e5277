#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include "assets/worlds/solids.h"
#include "assets/worlds/world_asset.h"
#include "assets/worlds/xml.h"
#include "base/text_scan.h"
#include "config/fields.h"

namespace scanmill {
namespace {

// Returns an element's <origin> as the transform from its frame to the enclosing frame; the identity if it has none.
Affine readOrigin(const XmlNode& owner) {
  const XmlNode* const origin = owner.child("origin");
  if (origin == nullptr) return {};
  const Vec3d position = vectorIn(*origin, origin->attributeOr("xyz", "0 0 0"));
  if (const std::string* text = origin->attribute("quat_xyzw")) {
    if (origin->attribute("rpy") != nullptr) origin->fail("has both rpy and quat_xyzw: leave out one of them");
    const std::vector<double> q = numbersIn(*origin, *text, 4);
    return toAffine({rotationOf(*origin, {q[3], q[0], q[1], q[2]}), position});
  }
  const auto [roll, pitch, yaw] = vectorIn(*origin, origin->attributeOr("rpy", "0 0 0"));
  return toAffine({fromYawPitchRoll(yaw, pitch, roll), position});
}

class UrdfReader {
 public:
  // `positions`: see AssetOptions::joints.
  UrdfReader(const std::filesystem::path& file, const std::map<std::string, double>& positions)
      : file_(file), root_(readXml(file)), positions_(positions) {
    if (root_.name != "robot") root_.fail("is not a URDF: its first element must be <robot>");
    countUnread(root_);
    readJoints();
    checkTree();
  }

  // Returns the transform from a link's frame to the robot's frame.
  Affine robotFromLink(const std::string& link) const {
    if (links_.contains(link)) return robotFromLinkOf(link, root_);
    root_.fail("has no link '{}'{}", link, suggestion(link, {links_.begin(), links_.end()}));
  }

  std::vector<std::string> linkNames() const {
    std::vector<std::string> names(links_.begin(), links_.end());
    std::partition(names.begin(), names.end(), [&](const std::string& name) { return !joints_.contains(name); });
    return names;
  }

  WorldFile read() {
    WorldThing robot{root_.attributeOr("name", "robot"), {}, {}, {}};
    for (const XmlNode& link : root_.children) {
      if (link.name != "link") continue;
      const std::string name = link.attributeOr("name", "link");
      const Affine robotFromLink = robotFromLinkOf(name, link);
      std::size_t number = 0;
      for (const XmlNode& visual : link.children) {
        if (visual.name == "visual") addVisual(visual, name, ++number, robotFromLink, robot.parts);
      }
    }
    world_.things.push_back(std::move(robot));
    return std::move(world_);
  }

 private:
  // Reads the joints, and the materials that visuals may name. Throws InputError if two links have the same name.
  void readJoints() {
    for (const XmlNode& child : root_.children) {
      if (child.name == "material") readMaterial(child);
      if (child.name == "joint") readJoint(child);
      const std::string name = child.attributeOr("name", "link");
      if (child.name == "link" && !links_.insert(name).second) {
        child.fail("has the name '{}', as another link: links need names of their own", name);
      }
    }
    for (const auto& [name, position] : positions_) {
      if (!jointNames_.contains(name)) {
        root_.fail("has no joint '{}'{}", name, suggestion(name, {jointNames_.begin(), jointNames_.end()}));
      }
    }
  }

  // Throws InputError if a joint names a link that does not exist, or if there are several root links.
  void checkTree() const {
    for (const auto& [child, joint] : joints_) {
      for (const std::string& link : {child, joint.parent}) {
        if (!links_.contains(link)) {
          throw InputError(joint.where, "<joint> names the link '{}', but this link does not exist", link);
        }
      }
    }
    std::optional<std::string> rootLink;
    for (const XmlNode& link : root_.children) {
      const std::string name = link.attributeOr("name", "link");
      if (link.name != "link" || joints_.contains(name)) continue;
      if (rootLink) {
        link.fail("'{}' and '{}' are both the child of no joint, but only one link can be the root", name, *rootLink);
      }
      rootLink = name;
    }
  }

  // Counts elements in `element` and below it that kUrdfFormat leaves out or does not know, or that stand where
  // kPlaces does not allow them. Throws InputError for macros.
  void countUnread(const XmlNode& element) {
    static constexpr std::array<ElementPlace, 9> kPlaces{{{"link joint", "robot", true},
                                                          {"visual", "link", true},
                                                          {"geometry", "visual collision"},
                                                          {"mesh box cylinder sphere capsule", "geometry"},
                                                          {"origin", "visual collision joint inertial sensor"},
                                                          {"material", "robot", true},
                                                          {"material", "visual"},
                                                          {"color", "material"},
                                                          {"texture", "material"}}};
    countMisplaced(element, kPlaces, world_.leftOut);
    for (const XmlNode& child : element.children) {
      const bool hasMacro = std::ranges::any_of(child.attributes, [](const auto& attribute) {
        return attribute.second.find("${") != std::string::npos || attribute.second.find("$(") != std::string::npos;
      });
      if (hasMacro || child.name.starts_with("xacro:")) {
        child.fail("has a macro: expand the file first, by `xacro robot.urdf.xacro > robot.urdf`");
      }
      world_.leftOut.addKeyword(kUrdfFormat, child.name);
      if (child.name == "gazebo") {
        const auto isLeftOut = [](const XmlNode& node) { return containsWord("material visual pose", node.name); };
        world_.leftOut.add("materials, visuals and poses for Gazebo",
                           static_cast<std::uint64_t>(std::ranges::count_if(child.children, isLeftOut)));
      }
      if (kUrdfFormat.useOf(child.name) == FormatSupport::Use::Read) countUnread(child);
    }
  }

  struct Joint {
    std::string parent;
    Affine parentFromChild;
    Location where;
  };

  // Adds a joint to joints_, at its given position, at that of the joint that it mimics, or at 0. Counts a joint at 0
  // whose limits exclude 0. Throws InputError if a link has two parents, or if a joint cannot have the given position.
  void readJoint(const XmlNode& joint) {
    const auto linkOf = [&](const char* role) {  // "parent" or "child"
      const XmlNode* const element = joint.child(role);
      const std::string* const link = element == nullptr ? nullptr : element->attribute("link");
      if (link == nullptr) joint.fail("has no <{} link=\"...\">", role);
      return *link;
    };
    const auto number = [&](const char* element, const char* attribute, const char* fallback) {
      const XmlNode* const node = joint.child(element);
      return std::strtod((node == nullptr ? fallback : node->attributeOr(attribute, fallback)).c_str(), nullptr);
    };
    const std::string type = joint.attributeOr("type", ""), name = joint.attributeOr("name", "joint");
    jointNames_.insert(name);
    const XmlNode* const mimic = joint.child("mimic");
    const auto given = positions_.find(mimic == nullptr ? name : mimic->attributeOr("joint", ""));
    double position = given == positions_.end() ? 0 : given->second;
    if (mimic != nullptr) position = number("mimic", "multiplier", "1") * position + number("mimic", "offset", "0");
    const bool hasLimits = type == "revolute" || type == "prismatic";
    const double lower = number("limit", "lower", "0"), upper = number("limit", "upper", "0");
    if (hasLimits && (position < lower || position > upper)) {
      if (position != 0) joint.fail("'{}' is from {} to {}, not at {}", name, lower, upper, position);
      world_.leftOut.add("joints whose limits exclude 0, where joints without a given position are");
    }
    Affine moved;
    if (position != 0) {
      const XmlNode* const axisNode = joint.child("axis");
      const Vec3d axis =
          axisNode == nullptr ? Vec3d{1, 0, 0} : vectorIn(*axisNode, axisNode->attributeOr("xyz", "1 0 0"));
      if (!(length(axis) > 0)) joint.fail("'{}' has an axis without a length", name);
      const Vec3d along = normalized(axis);
      if (type == "prismatic") {
        moved.translation = along * position;
      } else if (type == "revolute" || type == "continuous") {
        const Vec3d imaginary = along * std::sin(position / 2);
        moved = toAffine({{std::cos(position / 2), imaginary.x, imaginary.y, imaginary.z}, {}});
      } else {
        joint.fail("'{}' is {}: only joints that turn or slide have a position", name, type);
      }
    }
    if (!joints_.try_emplace(linkOf("child"), Joint{linkOf("parent"), readOrigin(joint) * moved, joint.where}).second) {
      joint.fail("gives the link '{}' a second parent joint", linkOf("child"));
    }
  }

  struct Look {
    std::optional<std::array<float, 3>> color;
    float opacity = 1;
    std::filesystem::path texture;
  };

  // Returns the look of a <material>. All materials of the same name have the first look that any of them states.
  Look readMaterial(const XmlNode& material) {
    const std::string name = material.attributeOr("name", "");
    if (looks_.contains(name)) return looks_.at(name);
    Look look;
    if (const XmlNode* color = material.child("color")) {
      const auto [r, g, b, alpha] = colorOf(*color, color->attributeOr("rgba", ""), world_.leftOut);
      look.color = {r, g, b};
      look.opacity = alpha;
    }
    if (const XmlNode* texture = material.child("texture")) {
      try {
        look.texture = findModel(*texture, file_, texture->attributeOr("filename", ""));
      } catch (const InputError&) {
        world_.leftOut.add(fmt::format("missing images '{}'", texture->attributeOr("filename", "")));
      }
    }
    if (!name.empty() && (look.color || !look.texture.empty())) looks_[name] = look;
    return look;
  }

  // Returns the transform from a link's frame to the robot's frame, which is the frame of the root link.
  Affine robotFromLinkOf(std::string name, const XmlNode& link) const {
    Affine robotFromLink;
    std::set<std::string> visitedLinks;
    for (auto joint = joints_.find(name); joint != joints_.end(); joint = joints_.find(name)) {
      if (!visitedLinks.insert(name).second) link.fail("'{}' is its own ancestor by the joints", name);
      robotFromLink = joint->second.parentFromChild * robotFromLink;
      name = joint->second.parent;
    }
    return robotFromLink;
  }

  // Adds a visual of a link, the `number`-th (from 1), unless it is invisible or its mesh is missing.
  void addVisual(const XmlNode& visual, const std::string& link, std::size_t number, const Affine& robotFromLink,
                 std::vector<WorldPart>& parts) {
    const XmlNode* const geometry = visual.child("geometry");
    if (geometry == nullptr || geometry->children.empty()) return;
    const XmlNode& shape = geometry->children.front();
    WorldPart part{.node = link + "/" + visual.attributeOr("name", fmt::format("visual_{}", number)),
                   .thingFromPart = robotFromLink * readOrigin(visual),
                   .where = visual.where};
    if (shape.name == "mesh") {
      try {
        part.shape = MeshFile{findModel(shape, file_, shape.attributeOr("filename", ""))};
      } catch (const MissingFileError& e) {
        return world_.missing.push_back(e);
      }
      part.thingFromPart.linear =
          part.thingFromPart.linear * Mat3::scale(vectorIn(shape, shape.attributeOr("scale", "1 1 1")));
    } else {
      std::optional<Mesh> solid = solidOf(shape);
      if (!solid) shape.fail("is not a shape of URDF (mesh, box, cylinder or sphere)");
      part.shape = std::move(*solid);
    }
    if (const XmlNode* material = visual.child("material")) {
      const Look look = readMaterial(*material);
      if (look.opacity <= 0) return world_.leftOut.add("invisible visuals (alpha 0)");
      if (look.opacity < 1) world_.leftOut.add("transparencies between 0 and 1 (these visuals are solid)");
      const bool isDefinition = material->child("color") != nullptr || material->child("texture") != nullptr;
      if (!look.color && look.texture.empty() && !isDefinition)
        world_.leftOut.add("materials that are defined nowhere");
      part.material = material->attributeOr("name", "");
      part.color = look.color;
      part.texture = look.texture;
    }
    parts.push_back(std::move(part));
  }

  std::filesystem::path file_;
  XmlNode root_;
  const std::map<std::string, double>& positions_;
  std::set<std::string> links_, jointNames_;
  std::map<std::string, Joint> joints_;  // joints, by name of their child link
  std::map<std::string, Look> looks_;
  WorldFile world_;
};

}  // namespace

const FormatSupport kUrdfFormat{
    "URDF",
    ".urdf",
    "One thing, whose parts are named robot/link/visual. Joints are at the positions of the object's key `joints`, at "
    "that of the joint that they mimic, or at 0. Meshes, whose up axis in COLLADA counts for nothing, as in ROS, and "
    "solids. A material replaces "
    "that of the mesh, except that a colour leaves the mesh's images; the first definition of a name holds for all; "
    "`rgba` is taken as linear light, since URDF states no colour space",
    "elements in a wrong place, and further ones where one may stand; invisible visuals (alpha 0); transparencies "
    "between 0 and 1 (these visuals are solid); numbers of colours above 1 (they count as 1); textures of parts "
    "without texture coordinates; materials that are defined nowhere; joints whose limits exclude 0, where joints "
    "without a given position are; materials, visuals and poses for Gazebo",
    {.read = {"robot link visual geometry joint origin parent child mesh box cylinder sphere capsule material",
              "color texture"},
     .unused = {"collision inertial axis calibration dynamics limit mimic safety_controller transmission contact",
                "gazebo sensor"}}};

WorldFile readUrdf(const std::filesystem::path& file, const std::map<std::string, double>& joints) {
  return UrdfReader(file, joints).read();
}

Affine robotFromLink(const std::filesystem::path& urdf, const std::map<std::string, double>& joints,
                     const std::string& link) {
  return UrdfReader(urdf, joints).robotFromLink(link);
}

std::vector<std::string> readLinkNames(const std::filesystem::path& urdf) {
  return UrdfReader(urdf, {}).linkNames();
}

}  // namespace scanmill
