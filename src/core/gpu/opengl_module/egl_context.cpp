#include "gpu/opengl_module/egl_context.h"

#include <EGL/eglext.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>

#include "gpu/device.h"

namespace scanmill {

namespace {

// A device that EGL may open.
struct Candidate {
  std::string name;  // the number among EGL's devices, or "surfaceless"
  EGLenum platform;
  void* nativeDisplay;  // second argument of eglGetPlatformDisplayEXT()
  bool software;        // true: a software rasteriser
};

// Returns true if a list of extensions, separated by spaces (null: none), has the extension.
bool hasExtension(const char* extensions, std::string_view extension) {
  const std::string list = fmt::format(" {} ", extensions != nullptr ? extensions : "");
  return list.find(fmt::format(" {} ", extension)) != list.npos;
}

template <class Function>
Function entry(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

// Returns the devices that can be tried: first the graphics cards, then the software rasterisers.
std::vector<Candidate> candidates() {
  const char* clientExtensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const auto hasClient = [&](const char* extension) { return hasExtension(clientExtensions, extension); };
  std::vector<Candidate> devices;
  const auto queryDevices = entry<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  if (queryDevices != nullptr && hasClient("EGL_EXT_platform_device") &&
      (hasClient("EGL_EXT_device_base") || hasClient("EGL_EXT_device_enumeration"))) {
    std::array<EGLDeviceEXT, 32> handles{};
    EGLint count = 0;
    if (queryDevices(static_cast<EGLint>(handles.size()), handles.data(), &count) == EGL_TRUE) {
      const auto query = entry<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
      for (EGLint i = 0; i < count; ++i) {
        const char* extensions = query != nullptr ? query(handles[i], EGL_EXTENSIONS) : nullptr;
        devices.push_back({fmt::format("{}", i), EGL_PLATFORM_DEVICE_EXT, handles[i],
                           hasExtension(extensions, "EGL_MESA_device_software")});
      }
    }
  }
  if (hasClient("EGL_MESA_platform_surfaceless")) {
    devices.push_back({"surfaceless", EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, true});
  }
  std::ranges::stable_partition(devices, [](const Candidate& c) { return !c.software; });
  return devices;
}

// Returns the devices to try. `device`: value of SCANMILL_GL_DEVICE (gpu/device.h). Throws if no device has this name.
std::vector<Candidate> candidatesFor(const std::string& device) {
  std::vector<Candidate> devices = candidates();
  if (device.empty()) return devices;
  std::string cards;
  for (const Candidate& c : devices) cards += c.software ? "" : c.name + ", ";
  std::erase_if(devices, [&](const Candidate& c) { return device == "software" ? !c.software : c.name != device; });
  if (devices.empty()) {
    throw std::invalid_argument(
        fmt::format("SCANMILL_GL_DEVICE: there is no device '{}' (known: {}software)", device, cards));
  }
  return devices;
}

// Creates a context of OpenGL 4.5 or, if that fails, of 4.3; returns null if both fail. If the driver supports it, the
// context reports that it was lost in a reset of the graphics card.
EGLContext newContext(EGLDisplay display, EGLConfig config) {
  for (const EGLint minorVersion : {5, 3}) {
    for (const bool reportsResets : {true, false}) {
      std::vector<EGLint> attributes{EGL_CONTEXT_MAJOR_VERSION,       4,
                                     EGL_CONTEXT_MINOR_VERSION,       minorVersion,
                                     EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
      if (reportsResets) {
        attributes.insert(attributes.end(),
                          {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
      }
      attributes.push_back(EGL_NONE);
      EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
      if (context != EGL_NO_CONTEXT) return context;
    }
  }
  return EGL_NO_CONTEXT;
}

// Creates a context on the device and makes it current. Returns the reason if this fails, otherwise an empty text.
std::string tryCandidate(const Candidate& candidate, EGLDisplay& display, EGLContext& context) {
  const auto getDisplay = entry<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (getDisplay == nullptr) return "it knows no platforms";
  display = getDisplay(candidate.platform, candidate.nativeDisplay, nullptr);
  EGLint major = 0;
  EGLint minor = 0;
  if (display == EGL_NO_DISPLAY || eglInitialize(display, &major, &minor) != EGL_TRUE) return "it does not start";
  if (!hasExtension(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context")) {
    return "it wants a surface";
  }
  if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) return "it has no OpenGL";
  const std::array<EGLint, 5> configuration{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                            EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  if (eglChooseConfig(display, configuration.data(), &config, 1, &configs) != EGL_TRUE || configs == 0) {
    config = nullptr;  // equals EGL_NO_CONFIG_KHR
  }
  context = newContext(display, config);
  if (context == EGL_NO_CONTEXT) return "it has no OpenGL 4.3";
  if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) != EGL_TRUE) {
    eglDestroyContext(display, context);
    context = EGL_NO_CONTEXT;
    return "its context cannot be used";
  }
  return {};
}

}  // namespace

std::vector<std::string> eglDevices() {
  std::vector<std::string> names;
  for (const Candidate& candidate : candidates()) {
    const std::string name = candidate.software ? "software" : candidate.name;
    if (names.empty() || names.back() != name) names.push_back(name);
  }
  return names;
}

EglContext::EglContext(const std::string& device) {
  std::string tried;
  for (const Candidate& candidate : candidatesFor(device)) {
    const std::string reason = tryCandidate(candidate, display_, context_);
    if (reason.empty()) return;
    tried += fmt::format("{}EGL device {}: {}", tried.empty() ? "" : "; ", candidate.name, reason);
  }
  throw NoDevice(tried.empty() ? "EGL has no device" : tried);
}

// Does not terminate the display, because other contexts of the process may use the display.
EglContext::~EglContext() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

bool EglContext::tryMakeCurrent() noexcept {
  eglBindAPI(EGL_OPENGL_API);
  if (eglGetCurrentContext() == context_) return true;
  return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
}

void EglContext::makeCurrent() {
  if (!tryMakeCurrent()) {
    throw std::runtime_error(fmt::format("the OpenGL context cannot be used (EGL error {:#x})", eglGetError()));
  }
}

}  // namespace scanmill
