#include "scene/texture.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"

namespace scanmill {

namespace {

constexpr int kMaxSize = 16384;

// The kinds that image bytes are recognised by; anything else is left to the name.
std::string kindOf(std::string_view bytes) {
  const auto starts = [&](std::string_view magic, std::size_t at = 0) {
    return bytes.size() >= at + magic.size() && bytes.substr(at, magic.size()) == magic;
  };
  if (starts("\x89PNG")) return "png";
  if (starts("\xff\xd8\xff")) return "jpg";
  if (starts("RIFF") && starts("WEBP", 8)) return "webp";
  if (starts("BM")) return "bmp";
  if (starts("GIF8")) return "gif";
  if (starts("DDS ")) return "dds";
  if (starts("\x01\xda")) return "sgi";
  if (starts("\x76\x2f\x31\x01")) return "exr";
  if (starts(std::string_view("II*\0", 4)) || starts(std::string_view("MM\0*", 4))) return "tif";
  return {};
}

// CRC-32 of PNG chunks (ISO 3309).
std::uint32_t crc(std::string_view bytes) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> out{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      out[i] = i;
      for (int bit = 0; bit < 8; ++bit) out[i] = (out[i] & 1) != 0 ? 0xEDB88320 ^ (out[i] >> 1) : out[i] >> 1;
    }
    return out;
  }();
  std::uint32_t value = 0xFFFFFFFF;
  for (const char c : bytes) value = table[(value ^ static_cast<std::uint8_t>(c)) & 255] ^ (value >> 8);
  return ~value;
}

std::uint32_t bigEndian(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word = word << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return word;
}

// A PNG reduced to the chunks that make its pixels, every one whole. libpng writes to standard error about damage, and
// about colour profiles, which texels as stored do not need.
std::string plainPng(std::string_view bytes, const std::string& name) {
  constexpr std::array<std::string_view, 5> kKept{"IHDR", "PLTE", "tRNS", "IDAT", "IEND"};
  std::string out(bytes.substr(0, 8));
  for (std::size_t at = 8; bytes.size() >= at + 12;) {
    const std::size_t size = bigEndian(bytes, at);
    if (size > bytes.size() - at - 12) break;
    const std::string_view kind = bytes.substr(at + 4, 4);
    if (crc(bytes.substr(at + 4, size + 4)) != bigEndian(bytes, at + 8 + size)) {
      throw InputError({name}, "the PNG is damaged");
    }
    if (std::find(kKept.begin(), kKept.end(), kind) != kKept.end()) out += bytes.substr(at, size + 12);
    at += size + 12;
    if (kind == "IEND") return out;
  }
  throw InputError({name}, "the PNG is truncated");
}

// OpenImageIO prints a message that nobody fetched when its thread or object ends.
std::string reason(const OIIO::ImageInput* input) {
  std::string text = input != nullptr ? input->geterror() : std::string();
  const std::string global = OIIO::geterror();
  if (text.empty()) text = global;
  while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "not an image that can be decoded" : text;
}

// By what an 8-bit colour that was multiplied by each alpha is multiplied to undo it. OpenImageIO multiplies WebP in
// linear light of that gamma.
std::array<float, 256> divisionByAlpha(double gamma) {
  std::array<float, 256> gain{};
  for (std::size_t i = 1; i < gain.size(); ++i) {
    gain[i] = static_cast<float>(std::pow(255.0 / static_cast<double>(i), 1.0 / gamma));
  }
  return gain;
}

std::shared_ptr<const Texture> decode(OIIO::ImageInput& input, const std::string& name) {
  const OIIO::ImageSpec& spec = input.spec();
  const auto fail = [&](const std::string& what) { return InputError({name}, what); };
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) throw fail("the image has no pixels");
  if (spec.width > kMaxSize || spec.height > kMaxSize) {
    throw fail(fmt::format("the image of {} x {} pixels is larger than {} x {}: scale it down", spec.width, spec.height,
                           kMaxSize, kMaxSize));
  }
  const int channels = spec.nchannels;
  const int alpha = spec.alpha_channel >= 0 && spec.alpha_channel < channels ? spec.alpha_channel : -1;
  const int colors = alpha >= 0 ? alpha : channels;  // alpha comes after the colours
  const std::array<int, 3> from = colors >= 3 ? std::array{0, 1, 2} : std::array{0, 0, 0};

  const std::size_t width = static_cast<std::size_t>(spec.width);
  const std::size_t height = static_cast<std::size_t>(spec.height);
  const std::size_t rowBytes = width * static_cast<std::size_t>(channels);
  std::vector<std::uint8_t> pixels(rowBytes * height);
  if (!input.read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, pixels.data())) {
    throw fail("the image cannot be decoded: " + reason(&input));
  }

  // Some readers multiply colours by alpha whatever they are asked for; they leave this attribute out.
  const bool multiplied = alpha >= 0 && spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0;
  const auto gain = divisionByAlpha(std::string_view(input.format_name()) == "webp" ? 2.2 : 1.0);
  auto texture = std::make_shared<Texture>();
  texture->file = name;
  texture->width = static_cast<std::uint32_t>(width);
  texture->height = static_cast<std::uint32_t>(height);
  texture->rgba.resize(width * height * 4);
  std::uint8_t least = 255;
  for (std::size_t row = 0; row < height; ++row) {
    const std::uint8_t* in = pixels.data() + (height - 1 - row) * rowBytes;
    std::uint8_t* out = texture->rgba.data() + row * width * 4;
    for (std::size_t column = 0; column < width; ++column, in += channels, out += 4) {
      out[0] = in[from[0]];
      out[1] = in[from[1]];
      out[2] = in[from[2]];
      out[3] = alpha >= 0 ? in[alpha] : std::uint8_t{255};
      least = std::min(least, out[3]);
      for (int i = 0; multiplied && i < 3; ++i) {
        out[i] = static_cast<std::uint8_t>(std::min(255.0f, static_cast<float>(out[i]) * gain[out[3]] + 0.5f));
      }
    }
  }
  texture->hasAlpha = least < 255;
  return texture;
}

std::unique_ptr<OIIO::ImageInput> openImage(const std::string& name, OIIO::Filesystem::IOProxy* bytes = nullptr) {
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // colours are wanted as painted, not multiplied by alpha
  if (bytes != nullptr) config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &bytes);
  return OIIO::ImageInput::open(name, &config, bytes);
}

std::shared_ptr<const Texture> decodeFile(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError({name}, "there is no such image");
  std::string magic(4, '\0');
  std::ifstream(path, std::ios::binary).read(magic.data(), 4);
  if (kindOf(magic) == "png") return decodeTexture(readFile(path), name);
  const auto input = openImage(name);
  if (!input) throw InputError({name}, "the image cannot be read: " + reason(nullptr));
  return decode(*input, name);
}

struct Cached {
  std::filesystem::file_time_type time;
  std::weak_ptr<const Texture> texture;
};

struct Linear {
  std::array<float, 256> of{};
  Linear() {
    for (std::size_t i = 0; i < of.size(); ++i) {
      const double s = static_cast<double>(i) / 255.0;
      of[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
  }
};

// The index of the texel that holds `coordinate`, repeated; 0 for what is not finite.
std::uint32_t texelIndex(float coordinate, std::uint32_t size) {
  const float part = coordinate - std::floor(coordinate);
  return part > 0.0f ? std::min(static_cast<std::uint32_t>(part * static_cast<float>(size)), size - 1) : 0;
}

}  // namespace

const std::uint8_t* Texture::texel(float u, float v) const {
  return rgba.data() + (std::size_t{texelIndex(v, height)} * width + texelIndex(u, width)) * 4;
}

std::shared_ptr<const Texture> loadTexture(const std::filesystem::path& path) {
  static std::mutex mutex;
  static std::map<std::string, Cached> cache;
  std::error_code error;
  const std::string key = std::filesystem::weakly_canonical(path, error).string();
  const auto time = std::filesystem::last_write_time(path, error);
  const auto known = [&]() -> std::shared_ptr<const Texture> {
    const auto found = cache.find(key);
    return found != cache.end() && found->second.time == time ? found->second.texture.lock() : nullptr;
  };
  {
    const std::scoped_lock lock(mutex);
    if (auto texture = known()) return texture;
  }
  auto texture = decodeFile(path);
  const std::scoped_lock lock(mutex);
  if (auto other = known()) return other;  // another thread was faster
  cache[key] = {time, texture};
  return texture;
}

std::shared_ptr<const Texture> decodeTexture(std::string_view bytes, const std::string& name) {
  const std::string kind = kindOf(bytes);
  const std::string hint = kind.empty() ? name : "embedded." + kind;
  const std::string png = kind == "png" ? plainPng(bytes, name) : std::string();
  if (kind == "png") bytes = png;
  OIIO::Filesystem::IOMemReader reader(bytes.data(), bytes.size());
  const auto input = openImage(hint, &reader);
  if (!input) throw InputError({name}, "the image cannot be read: " + reason(nullptr));
  return decode(*input, name);
}

bool mayHaveAlpha(const std::filesystem::path& path) {
  const auto input = openImage(path.string());
  if (!input) {
    OIIO::geterror();
    return true;
  }
  return input->spec().alpha_channel >= 0;
}

std::shared_ptr<const Texture> withOpacity(const Texture* color, const Texture& opacity, bool inverted) {
  auto texture = std::make_shared<Texture>();
  texture->file = color != nullptr ? color->file : opacity.file;
  texture->width = std::max(opacity.width, color != nullptr ? color->width : 0);
  texture->height = std::max(opacity.height, color != nullptr ? color->height : 0);
  texture->rgba.resize(std::size_t{texture->width} * texture->height * 4);
  std::uint8_t* out = texture->rgba.data();
  for (std::uint32_t row = 0; row < texture->height; ++row) {
    const float v = (static_cast<float>(row) + 0.5f) / static_cast<float>(texture->height);
    for (std::uint32_t column = 0; column < texture->width; ++column, out += 4) {
      const float u = (static_cast<float>(column) + 0.5f) / static_cast<float>(texture->width);
      const std::uint8_t* map = opacity.texel(u, v);
      const int value = opacity.hasAlpha ? map[3] : (map[0] + map[1] + map[2] + 1) / 3;
      out[3] = static_cast<std::uint8_t>(inverted ? 255 - value : value);
      if (color != nullptr) {
        std::copy_n(color->texel(u, v), 3, out);
      } else {
        std::fill_n(out, 3, std::uint8_t{255});
      }
      texture->hasAlpha = texture->hasAlpha || out[3] < 255;
    }
  }
  return texture;
}

float luminance(const std::uint8_t* rgb) {
  static const Linear linear;
  return 0.2126f * linear.of[rgb[0]] + 0.7152f * linear.of[rgb[1]] + 0.0722f * linear.of[rgb[2]];
}

float meanLuminance(const Texture& texture, float minimumAlpha) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + 3 < texture.rgba.size(); i += 4) {
    if (static_cast<float>(texture.rgba[i + 3]) < minimumAlpha * 255.0f) continue;
    sum += static_cast<double>(luminance(&texture.rgba[i]));
    ++count;
  }
  return count == 0 ? 1.0f : static_cast<float>(sum / static_cast<double>(count));
}

}  // namespace scanmill
