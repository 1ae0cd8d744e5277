#include "assets/worlds/ogre_material.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "base/file.h"

namespace scanmill {
namespace {

// Returns the text without its comments, and with each brace on a line of its own.
std::string inLines(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 2, "//") == 0) i = std::min(text.find('\n', i), text.size());
    if (text.compare(std::min(i, text.size()), 2, "/*") == 0) i = std::min(text.find("*/", i), text.size() - 2) + 2;
    if (i >= text.size()) break;
    plain += text[i] == '{' || text[i] == '}' ? std::string{'\n', text[i], '\n'} : std::string(1, text[i]);
  }
  return plain;
}

float fractionOf(const std::string& word) {
  return std::clamp(std::strtof(word.c_str(), nullptr), 0.0f, 1.0f);
}

void readScript(const std::filesystem::path& file, std::map<std::string, OgreMaterial>& materials, LeftOut& leftOut) {
  std::istringstream lines(inLines(readFile(file)));
  OgreMaterial* current = nullptr;
  int depth = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    if (words.empty()) continue;
    if (depth == 0 && words[0] == "material" && words.size() > 1) {
      current = &materials[words[1]];
      if (words.size() > 3 && words[2] == ":") current->base = words[3];
    }
    if (words[0] == "{") ++depth;
    if (words[0] == "}") --depth;
    if (depth <= 0 && words[0] == "}") current = nullptr;
    if (current == nullptr || words[0] == "{" || words[0] == "}") continue;
    leftOut.addKeyword(ogreFormat(), words[0]);
    if (words[0] == "texture" && words.size() > 1 && current->texture.empty()) current->texture = words[1];
    if (words[0] == "diffuse" && words.size() > 3 && !current->color) {
      current->color = {fractionOf(words[1]), fractionOf(words[2]), fractionOf(words[3])};
    }
    if (words[0] == "alpha_rejection" && words.size() > 2 && words[1].starts_with("greater")) {
      current->alphaCutoff = std::clamp(std::strtof(words[2].c_str(), nullptr) / 255, 0.0f, 1.0f);
    }
  }
}

// Gives a material the properties of those from which it inherits.
void inherit(OgreMaterial& material, const std::map<std::string, OgreMaterial>& materials) {
  constexpr int kDeepest = 32;
  std::string name = material.base;
  for (int i = 0; i < kDeepest; ++i) {
    const auto base = materials.find(name);
    if (base == materials.end()) return;
    if (material.texture.empty()) material.texture = base->second.texture;
    if (!material.color) material.color = base->second.color;
    if (!material.alphaCutoff) material.alphaCutoff = base->second.alphaCutoff;
    name = base->second.base;
  }
}

}  // namespace

const FormatSupport& ogreFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "OGRE material",
      ".material",
      {{Read, "material technique pass texture_unit", "materials by name, with what they inherit from one before them"},
       {Read, "texture", "the first image of a material"},
       {Read, "diffuse", "the first colour of a material, taken as linear light; OGRE states no colour space"},
       {Read, "alpha_rejection", "greater and greater_equal: beams pass where alpha is below the value"},
       {LeftOut, "scene_blend separate_scene_blend", "blended materials, which are solid (scene_blend)"},
       {LeftOut, "anim_texture cubic_texture", "images in several files (anim_texture, cubic_texture)"},
       {LeftOut, "set_texture_alias texture_alias", "aliases of textures"},
       {LeftOut, "scroll scale rotate transform tex_coord_set", "changes of texture coordinates"},
       {Unused, "ambient specular emissive lighting shading normalise_normals max_lights start_light iteration",
        "lighting"},
       {Unused, "light_scissor light_clip_planes illumination_stage fog_override env_map receive_shadows", "lighting"},
       {Unused, "cull_hardware cull_software depth_check depth_write depth_func depth_bias iteration_depth_bias",
        "display; beams meet both sides"},
       {Unused,
        "scene_blend_op separate_scene_blend_op alpha_to_coverage transparent_sorting colour_write polygon_mode",
        "display"},
       {Unused,
        "polygon_mode_overrideable point_size point_sprites point_size_attenuation point_size_min point_size_max",
        "display"},
       {Unused, "tex_address_mode tex_border_colour filtering max_anisotropy mipmap_bias colour_op colour_op_ex",
        "display"},
       {Unused, "colour_op_multipass_fallback alpha_op_ex scroll_anim rotate_anim wave_xform binding_type content_type",
        "display"},
       {Unused, "lod_strategy lod_values lod_distances lod_index scheme gpu_vendor_rule gpu_device_rule", "display"},
       {Unused, "transparency_casts_shadows shadow_caster_material shadow_receiver_material", "shadows"},
       {Unused, "vertex_program_ref fragment_program_ref geometry_program_ref rtshader_system param_named", "shaders"},
       {Unused, "shadow_caster_vertex_program_ref shadow_receiver_vertex_program_ref param_named_auto", "shaders"},
       {Unused, "shadow_receiver_fragment_program_ref shadow_caster_fragment_program_ref param_indexed", "shaders"},
       {Unused, "param_indexed_auto lighting_stage shared_params_ref", "shaders"}}};
  return format;
}

std::map<std::string, OgreMaterial> readOgreMaterials(const std::filesystem::path& place, LeftOut& leftOut) {
  std::map<std::string, OgreMaterial> materials;
  std::error_code error;
  std::vector<std::filesystem::path> scripts;
  if (std::filesystem::is_regular_file(place, error)) scripts.push_back(place);
  for (const auto& entry : std::filesystem::directory_iterator(place, error)) {
    if (entry.path().extension() == ".material" && entry.is_regular_file(error)) scripts.push_back(entry.path());
  }
  std::sort(scripts.begin(), scripts.end());
  for (const std::filesystem::path& script : scripts) readScript(script, materials, leftOut);
  for (auto& [name, material] : materials) inherit(material, materials);
  return materials;
}

}  // namespace scanmill
