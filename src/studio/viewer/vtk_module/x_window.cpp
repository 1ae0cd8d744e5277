#include "viewer/vtk_module/x_window.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/cursorfont.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <utility>
#include <vector>

#include "gpu/device.h"
#include "viewer/vtk_module/x_events.h"

namespace scanmill {

namespace {

using Clock = std::chrono::steady_clock;

// Xlib's handlers know no object; of windows there is one at a time.
std::string& complaint() {
  static std::string text;
  return text;
}

int keepComplaint(Display* display, XErrorEvent* error) {
  if (complaint().empty()) {
    std::array<char, 256> text{};
    XGetErrorText(display, error->error_code, text.data(), static_cast<int>(text.size()));
    complaint() =
        fmt::format("the X server says: {} (request {}.{})", text.data(), error->request_code, error->minor_code);
  }
  return 0;
}

// It must not return: Xlib would end the program by itself, by way of the destructors of what is in use.
int endProgram(Display*) {
  constexpr std::string_view kMessage = "error: the connection to the X server, and with it the window, is lost\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kMessage.data(), kMessage.size());
  std::_Exit(1);
}

// A server lists several visuals that look the same; one with an alpha channel would let the desktop shine through.
EGLConfig configOf(EGLDisplay display, Display* server, XVisualInfo& visual) {
  const std::array<EGLint, 11> wanted{EGL_SURFACE_TYPE,
                                      EGL_WINDOW_BIT,
                                      EGL_RENDERABLE_TYPE,
                                      EGL_OPENGL_BIT,
                                      EGL_RED_SIZE,
                                      5,
                                      EGL_GREEN_SIZE,
                                      5,
                                      EGL_BLUE_SIZE,
                                      5,
                                      EGL_NONE};
  std::array<EGLConfig, 256> configs{};
  EGLint count = 0;
  eglChooseConfig(display, wanted.data(), configs.data(), static_cast<EGLint>(configs.size()), &count);
  const VisualID usual = XVisualIDFromVisual(DefaultVisual(server, DefaultScreen(server)));
  EGLConfig best = nullptr;
  VisualID bestVisual = 0;
  for (EGLint i = 0; i < count; ++i) {
    EGLint id = 0;
    EGLint alpha = 0;
    eglGetConfigAttrib(display, configs[i], EGL_NATIVE_VISUAL_ID, &id);
    eglGetConfigAttrib(display, configs[i], EGL_ALPHA_SIZE, &alpha);
    const auto found = static_cast<VisualID>(id);
    if (found == 0 || (alpha > 0 && found != usual)) continue;
    if (best == nullptr || (found == usual && bestVisual != usual)) {
      best = configs[i];
      bestVisual = found;
    }
  }
  if (best == nullptr) throw NoDevice("the X server has no visual on which EGL draws");
  XVisualInfo wantedVisual{};
  wantedVisual.visualid = bestVisual;
  int visuals = 0;
  XVisualInfo* list = XGetVisualInfo(server, VisualIDMask, &wantedVisual, &visuals);
  if (list == nullptr) throw NoDevice("the X server does not know EGL's visual");
  visual = list[0];
  XFree(list);
  return best;
}

}  // namespace

struct XWindow::State {
  Display* server = nullptr;
  ::Window window = 0;
  Colormap colors = 0;
  Cursor cursor = 0;
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  EGLSurface surface = EGL_NO_SURFACE;
  XErrorHandler errorsBefore = nullptr;
  XIOErrorHandler lossBefore = nullptr;
  std::unique_ptr<XEvents> events;

  void connect();
  void start();
  void create(const XVisualInfo& visual, const std::string& title, int width, int height);
  void makeContext(EGLConfig config);
  ~State();
};

void XWindow::State::connect() {
  const char* name = std::getenv("DISPLAY");
  const std::string instead = "or take a picture without one: --screenshot FILE.png";
  if (name == nullptr || *name == '\0') {
    throw NoDisplay(fmt::format("there is no display for a window: DISPLAY is not set; set it, {}", instead));
  }
  server = XOpenDisplay(name);
  if (server == nullptr) {
    throw NoDisplay(
        fmt::format("there is no display for a window: the X server {} (DISPLAY) does not answer or lets nobody in; "
                    "set DISPLAY, {}",
                    name, instead));
  }
  complaint().clear();
  errorsBefore = XSetErrorHandler(keepComplaint);
  lossBefore = XSetIOErrorHandler(endProgram);
}

void XWindow::State::start() {
  // Mesa tells by a warning that the server has no graphics card, and goes on without one.
  ::setenv("EGL_LOG_LEVEL", "fatal", 0);
  const auto getDisplay =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  display = getDisplay != nullptr ? getDisplay(EGL_PLATFORM_X11_EXT, server, nullptr) : EGL_NO_DISPLAY;
  EGLint major = 0;
  EGLint minor = 0;
  if (display == EGL_NO_DISPLAY || eglInitialize(display, &major, &minor) != EGL_TRUE) {
    throw NoDevice("EGL does not draw on this X server");
  }
  if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) throw NoDevice("EGL has no OpenGL on this X server");
}

void XWindow::State::create(const XVisualInfo& visual, const std::string& title, int width, int height) {
  const ::Window root = RootWindow(server, visual.screen);
  colors = XCreateColormap(server, root, visual.visual, AllocNone);
  XSetWindowAttributes attributes{};
  attributes.colormap = colors;
  attributes.border_pixel = 0;
  attributes.background_pixmap = None;  // not cleared by the server, which would flicker
  attributes.bit_gravity = NorthWestGravity;
  window =
      XCreateWindow(server, root, 0, 0, static_cast<unsigned>(width), static_cast<unsigned>(height), 0, visual.depth,
                    InputOutput, visual.visual, CWColormap | CWBorderPixel | CWBackPixmap | CWBitGravity, &attributes);
  XSizeHints sizes{};
  sizes.flags = PSize | PMinSize;
  sizes.width = width;
  sizes.height = height;
  sizes.min_width = 160;
  sizes.min_height = 120;
  XWMHints hints{};
  hints.flags = InputHint | StateHint;
  hints.input = True;
  hints.initial_state = NormalState;
  std::string name = "scanmill";
  std::string group = "Scanmill";
  XClassHint names{name.data(), group.data()};
  Xutf8SetWMProperties(server, window, title.c_str(), title.c_str(), nullptr, 0, &sizes, &hints, &names);
  const Atom text = XInternAtom(server, "UTF8_STRING", False);
  for (const char* property : {"_NET_WM_NAME", "_NET_WM_ICON_NAME"}) {
    XChangeProperty(server, window, XInternAtom(server, property, False), text, 8, PropModeReplace,
                    reinterpret_cast<const unsigned char*>(title.data()), static_cast<int>(title.size()));
  }
  cursor = XCreateFontCursor(server, XC_left_ptr);
  XDefineCursor(server, window, cursor);
  events = std::make_unique<XEvents>(server, window, width, height);
}

void XWindow::State::makeContext(EGLConfig config) {
  surface = eglCreateWindowSurface(display, config, window, nullptr);
  if (surface == EGL_NO_SURFACE) throw NoDevice("EGL does not draw on a window of this X server");
  const std::array<std::pair<EGLint, EGLint>, 3> versions{{{4, 5}, {4, 3}, {3, 2}}};
  for (const auto& [major, minor] : versions) {
    const std::array<EGLint, 7> attributes{
        EGL_CONTEXT_MAJOR_VERSION,           major,   EGL_CONTEXT_MINOR_VERSION, minor, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
    if (context != EGL_NO_CONTEXT) break;
  }
  if (context == EGL_NO_CONTEXT) throw NoDevice("there is no OpenGL 3.2 on this X server");
  if (eglMakeCurrent(display, surface, surface, context) != EGL_TRUE) {
    throw NoDevice("the OpenGL context of the window cannot be used");
  }
}

// EGL's display belongs to the connection, so it ends with it.
XWindow::State::~State() {
  events.reset();
  if (display != EGL_NO_DISPLAY) {
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    if (surface != EGL_NO_SURFACE) eglDestroySurface(display, surface);
    eglTerminate(display);
  }
  if (server == nullptr) return;
  if (window != 0) XDestroyWindow(server, window);
  if (colors != 0) XFreeColormap(server, colors);
  if (cursor != 0) XFreeCursor(server, cursor);
  XCloseDisplay(server);
  XSetErrorHandler(errorsBefore);
  XSetIOErrorHandler(lossBefore);
}

XWindow::XWindow(const std::string& title, int width, int height) : state_(std::make_unique<State>()) {
  constexpr int kLargest = 32767;  // X's numbers have 16 bits
  if (width < 1 || height < 1 || width > kLargest || height > kLargest) {
    throw std::invalid_argument(fmt::format("a window of {} x {} pixels cannot be made", width, height));
  }
  state_->connect();
  state_->start();
  XVisualInfo visual{};
  EGLConfig config = configOf(state_->display, state_->server, visual);
  state_->create(visual, title, width, height);
  state_->makeContext(config);
  XSync(state_->server, False);
  check();
}

XWindow::~XWindow() = default;

bool XWindow::tryMakeCurrent() noexcept {
  eglBindAPI(EGL_OPENGL_API);
  return eglMakeCurrent(state_->display, state_->surface, state_->surface, state_->context) == EGL_TRUE;
}

void XWindow::makeCurrent() {
  if (!tryMakeCurrent()) {
    throw std::runtime_error(
        fmt::format("the window's OpenGL context cannot be used (EGL error {:#x})", eglGetError()));
  }
}

void XWindow::present() {
  XEventsQueued(state_->server, QueuedAfterFlush);  // notices a lost connection, on which Mesa would go round for long
  if (eglSwapBuffers(state_->display, state_->surface) != EGL_TRUE) {
    throw std::runtime_error(fmt::format("the window cannot be drawn (EGL error {:#x})", eglGetError()));
  }
}

void XWindow::resize(int width, int height) {
  XResizeWindow(state_->server, state_->window, static_cast<unsigned>(width), static_cast<unsigned>(height));
  XSync(state_->server, False);
}

void XWindow::check() {
  if (const std::string text = std::exchange(complaint(), {}); !text.empty()) throw std::runtime_error(text);
}

void XWindow::run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handler) {
  const std::chrono::milliseconds tick(tickMilliseconds);
  XMapRaised(state_->server, state_->window);
  XEvents& events = *state_->events;
  if (!handler(events.size())) return;
  Clock::time_point next = Clock::now() + tick;
  for (;;) {
    // A tick that is due goes before further events, or a moving mouse could keep it away for ever.
    while ((tickMilliseconds <= 0 || Clock::now() < next) && XPending(state_->server) > 0) {
      const std::optional<CanvasEvent> event = events.take();
      if (!event) continue;
      const bool more = handler(*event);
      check();
      if (!more || event->kind == CanvasEvent::Kind::Close) return;
    }
    if (tickMilliseconds > 0 && Clock::now() >= next) {
      if (!handler(events.plain(CanvasEvent::Kind::Tick))) return;
      check();
      next = std::max(next + tick, Clock::now());  // those missed are not made up for
      if (XPending(state_->server) > 0) {
        // At least one event between two ticks.
        const std::optional<CanvasEvent> event = events.take();
        if (event && (!handler(*event) || event->kind == CanvasEvent::Kind::Close)) return;
      }
      continue;
    }
    pollfd connection{ConnectionNumber(state_->server), POLLIN, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(next - Clock::now()).count() + 1;
    const int wait = tickMilliseconds <= 0 ? -1 : static_cast<int>(std::max<std::int64_t>(left, 0));
    if (::poll(&connection, 1, wait) < 0 && errno != EINTR) {
      throw std::runtime_error("the X server cannot be waited for");
    }
  }
}

}  // namespace scanmill
