#include "viewer/vtk_module/glfw_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <chrono>
#include <deque>
#include <utility>

#include "gpu/device.h"

namespace scanmill {

namespace {

using Clock = std::chrono::steady_clock;
using Kind = CanvasEvent::Kind;

constexpr double kDoubleClick = 0.4;  // maximum time between the presses of a double click (s)
constexpr double kSamePlace = 4;      // maximum distance between the presses of a double click (pixels)

// Returns the first error message of GLFW since the last check; empty if there was none. The message is global, since
// GLFW's error handler does not get the window; only one window can be open at a time.
std::string& firstError() {
  static std::string text;
  return text;
}

// Connects to the X server. Throws Error if this fails.
void connectToDisplay() {
  firstError().clear();
  glfwSetErrorCallback([](int /*code*/, const char* text) {
    if (firstError().empty()) firstError() = text;
  });
  // Suppresses Mesa's warning that the X server has no graphics card, which Mesa does not need.
  ::setenv("EGL_LOG_LEVEL", "fatal", 0);
#ifdef GLFW_PLATFORM
  glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);  // GLFW 3.4 tries Wayland first, but VTK supports only X11
#endif
  if (glfwInit() == GLFW_TRUE) return;
  const char* const display = std::getenv("DISPLAY");
  constexpr std::string_view kInstead = "or take a picture without one: --screenshot FILE.png";
  if (display == nullptr || *display == '\0') {
    throw Error("there is no display for a window: DISPLAY is not set; set it, {}", kInstead);
  }
  throw Error(
      "there is no display for a window: the X server {} (DISPLAY) does not answer or lets nobody in ({}); set "
      "DISPLAY, "
      "{}",
      display, firstError(), kInstead);
}

// Creates an invisible window with OpenGL 4.5, else 4.3, else 3.2. Throws NoDevice if the display has none of these.
GLFWwindow* createWindow(const std::string& title, int width, int height) {
  constexpr std::array<std::pair<int, int>, 3> kVersions{{{4, 5}, {4, 3}, {3, 2}}};
  for (const auto& [major, minor] : kVersions) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_FOCUS_ON_SHOW, GLFW_TRUE);
    glfwWindowHint(GLFW_ALPHA_BITS, 0);  // with an alpha channel, the desktop would be visible through the window
    glfwWindowHint(GLFW_DEPTH_BITS, 0);  // VTK draws to a separate framebuffer
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_EGL_CONTEXT_API);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHintString(GLFW_X11_CLASS_NAME, "Scanmill");
    glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "scanmill");
    firstError().clear();
    if (GLFWwindow* const window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr)) return window;
  }
  throw NoDevice(fmt::format("there is no OpenGL 3.2 for a window on this display: {}", firstError()));
}

// Returns the name of a key that types no character, such as "Left"; empty for other keys. `numLock`: if false, keys of
// the number pad have the functions printed below their digits.
std::string nameOf(int key, bool numLock) {
  if (!numLock && key >= GLFW_KEY_KP_0 && key <= GLFW_KEY_KP_9) {
    constexpr std::array<std::string_view, 10> kPad{"", "End",   "Down", "Page_Down", "Left",
                                                    "", "Right", "Home", "Up",        "Page_Up"};
    return std::string(kPad[static_cast<std::size_t>(key - GLFW_KEY_KP_0)]);
  }
  if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12) return fmt::format("F{}", key - GLFW_KEY_F1 + 1);
  constexpr std::pair<int, const char*> kOthers[]{{GLFW_KEY_ESCAPE, "Escape"},
                                                  {GLFW_KEY_ENTER, "Return"},
                                                  {GLFW_KEY_KP_ENTER, "Return"},
                                                  {GLFW_KEY_TAB, "Tab"},
                                                  {GLFW_KEY_BACKSPACE, "BackSpace"},
                                                  {GLFW_KEY_RIGHT, "Right"},
                                                  {GLFW_KEY_LEFT, "Left"},
                                                  {GLFW_KEY_UP, "Up"},
                                                  {GLFW_KEY_DOWN, "Down"},
                                                  {GLFW_KEY_PAGE_UP, "Page_Up"},
                                                  {GLFW_KEY_PAGE_DOWN, "Page_Down"},
                                                  {GLFW_KEY_HOME, "Home"},
                                                  {GLFW_KEY_END, "End"}};
  const auto found = std::ranges::find(kOthers, key, &std::pair<int, const char*>::first);
  return found == std::end(kOthers) ? "" : found->second;
}

// Returns a code point in UTF-8: the first byte states the number of further bytes, which hold 6 bits each.
std::string utf8(unsigned codepoint) {
  if (codepoint < 0x80) return {static_cast<char>(codepoint)};
  const int moreBytes = codepoint < 0x800 ? 1 : codepoint < 0x10000 ? 2 : 3;
  constexpr std::array<unsigned, 4> kFirstBytes{0, 0xC0, 0xE0, 0xF0};
  std::string text{static_cast<char>(kFirstBytes[static_cast<std::size_t>(moreBytes)] | codepoint >> 6 * moreBytes)};
  for (int i = moreBytes - 1; i >= 0; --i) text += static_cast<char>(0x80 | (codepoint >> 6 * i & 0x3F));
  return text;
}

}  // namespace

struct GlfwWindow::State {
  GLFWwindow* window = nullptr;
  std::deque<CanvasEvent> events;
  int width = 0, height = 0, x = 0, y = 0;
  bool shift = false;
  bool control = false;
  CanvasEvent lastPress;
  double pressedAt = 0;  // time of the last press (s)
  int clicks = 0;        // 2 if the last press ended a double click, else 1; 0: no press yet

  ~State() {
    if (window != nullptr) glfwDestroyWindow(window);
    glfwTerminate();
  }

  static State& of(GLFWwindow* window) { return *static_cast<State*>(glfwGetWindowUserPointer(window)); }

  // Returns an event with the current state of the pointer, the modifier keys and the window.
  CanvasEvent eventOf(Kind kind) const {
    return {.kind = kind, .x = x, .y = y, .shift = shift, .control = control, .width = width, .height = height};
  }

  // Appends an event to the queue. A Move, Resize or Redraw replaces the last event if this is of the same kind.
  void add(CanvasEvent event) {
    const bool replaces = event.kind == Kind::Move || event.kind == Kind::Resize || event.kind == Kind::Redraw;
    if (replaces && !events.empty() && events.back().kind == event.kind) events.pop_back();
    events.push_back(std::move(event));
  }

  void setModifiers(int mods) {
    shift = (mods & GLFW_MOD_SHIFT) != 0;
    control = (mods & GLFW_MOD_CONTROL) != 0;
  }

  // Handles keys that type no character, and all keys pressed with control; typed() handles all other keys.
  void key(int code, int scan, int mods) {
    setModifiers(mods);
    std::string name = nameOf(code, (mods & GLFW_MOD_NUM_LOCK) != 0);
    const char* const typed = control ? glfwGetKeyName(code, scan) : nullptr;
    if (name.empty() && typed != nullptr) name = typed;
    if (name.empty()) return;
    CanvasEvent event = eventOf(Kind::Key);
    event.key = std::move(name);
    add(std::move(event));
  }

  void typed(unsigned codepoint) {
    CanvasEvent event = eventOf(Kind::Key);
    event.key = event.text = utf8(codepoint);
    add(std::move(event));
  }

  // Handles a press (`down`) or release of a mouse button. `code`, `mods`: GLFW's button and modifier keys.
  void button(int code, bool down, int mods) {
    constexpr std::array<int, 3> kNumbers{1, 3, 2};  // GLFW's order is left, right, middle
    if (code < 0 || code >= static_cast<int>(kNumbers.size())) return;
    setModifiers(mods);
    CanvasEvent event = eventOf(down ? Kind::Down : Kind::Up);
    event.button = kNumbers[static_cast<std::size_t>(code)];
    if (down) {
      const double now = glfwGetTime();
      const bool isDoubleClick = clicks == 1 && event.button == lastPress.button && now - pressedAt <= kDoubleClick &&
                                 std::abs(x - lastPress.x) <= kSamePlace && std::abs(y - lastPress.y) <= kSamePlace;
      clicks = isDoubleClick ? 2 : 1;
      pressedAt = now;
      lastPress = event;
    }
    event.clicks = std::max(clicks, 1);
    add(std::move(event));
  }

  // Registers GLFW callbacks, which append events to the queue.
  void listen() {
    glfwSetWindowUserPointer(window, this);
    glfwSetInputMode(window, GLFW_LOCK_KEY_MODS, GLFW_TRUE);
    glfwSetKeyCallback(window, [](GLFWwindow* from, int code, int scan, int action, int mods) {
      if (action != GLFW_RELEASE) return of(from).key(code, scan, mods);
      // X still reports a modifier as pressed in the event of its release, so the state of the keys is read.
      const auto isPressed = [&](int left, int right) {
        return glfwGetKey(from, left) == GLFW_PRESS || glfwGetKey(from, right) == GLFW_PRESS;
      };
      of(from).shift = isPressed(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT);
      of(from).control = isPressed(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL);
    });
    glfwSetCharCallback(window, [](GLFWwindow* from, unsigned codepoint) { of(from).typed(codepoint); });
    glfwSetCursorPosCallback(window, [](GLFWwindow* from, double atX, double atY) {
      State& s = of(from);
      s.x = static_cast<int>(atX);
      s.y = static_cast<int>(atY);
      s.add(s.eventOf(Kind::Move));
    });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* from, int code, int action, int mods) {
      of(from).button(code, action == GLFW_PRESS, mods);
    });
    glfwSetScrollCallback(window, [](GLFWwindow* from, double, double amount) {
      State& s = of(from);
      CanvasEvent event = s.eventOf(Kind::Wheel);
      event.amount = amount;
      if (amount != 0) s.add(std::move(event));
    });
    glfwSetFramebufferSizeCallback(window, [](GLFWwindow* from, int newWidth, int newHeight) {
      State& s = of(from);
      if (newWidth < 1 || newHeight < 1 || (newWidth == s.width && newHeight == s.height)) return;
      s.width = newWidth;
      s.height = newHeight;
      s.add(s.eventOf(Kind::Resize));
    });
    glfwSetWindowRefreshCallback(window, [](GLFWwindow* from) { of(from).add(of(from).eventOf(Kind::Redraw)); });
    glfwSetWindowCloseCallback(window, [](GLFWwindow* from) { of(from).add(of(from).eventOf(Kind::Close)); });
  }
};

GlfwWindow::GlfwWindow(const std::string& title, int width, int height) : state_(std::make_unique<State>()) {
  constexpr int kLargest = 32767;  // X stores sizes in 16 bits
  constexpr int kLeastWidth = 160;
  constexpr int kLeastHeight = 120;
  if (width < 1 || height < 1 || width > kLargest || height > kLargest) {
    throw std::invalid_argument(fmt::format("a window of {} x {} pixels cannot be made", width, height));
  }
  connectToDisplay();
  state_->window = createWindow(title, width, height);
  glfwSetWindowSizeLimits(state_->window, std::min(width, kLeastWidth), std::min(height, kLeastHeight), GLFW_DONT_CARE,
                          GLFW_DONT_CARE);
  glfwGetFramebufferSize(state_->window, &state_->width, &state_->height);
  glfwMakeContextCurrent(state_->window);
  state_->listen();
  check();
}

GlfwWindow::~GlfwWindow() = default;

void GlfwWindow::makeCurrent() noexcept {
  glfwMakeContextCurrent(state_->window);
}

double GlfwWindow::scale() const {
  float across = 1;
  glfwGetWindowContentScale(state_->window, &across, nullptr);
  return across;
}

void GlfwWindow::present() {
  glfwPollEvents();  // detects a lost connection, which Mesa would not notice for a long time
  glfwSwapBuffers(state_->window);
}

void GlfwWindow::check() {
  if (const std::string text = std::exchange(firstError(), {}); !text.empty()) throw std::runtime_error(text);
}

void GlfwWindow::run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handler) {
  State& s = *state_;
  const std::chrono::milliseconds tick(tickMilliseconds);
  glfwShowWindow(s.window);
  glfwPollEvents();
  s.events.clear();
  if (!handler(s.eventOf(Kind::Resize))) return;
  // Removes the first event and passes it to the handler. Returns false if the loop should end.
  const auto handleNext = [&] {
    const CanvasEvent event = std::move(s.events.front());
    s.events.pop_front();
    const bool goesOn = handler(event);
    check();
    return goesOn && event.kind != Kind::Close;
  };
  Clock::time_point due = Clock::now() + tick;  // time of the next tick
  for (;;) {
    glfwPollEvents();
    // A due tick is sent before further events; otherwise a moving mouse could delay it forever.
    while (Clock::now() < due && !s.events.empty()) {
      if (!handleNext()) return;
    }
    if (Clock::now() >= due) {
      if (!handler(s.eventOf(Kind::Tick))) return;
      check();
      due = std::max(due + tick, Clock::now());        // skips missed ticks
      if (!s.events.empty() && !handleNext()) return;  // at least one event is handled between two ticks
      continue;
    }
    glfwWaitEventsTimeout(std::max(std::chrono::duration<double>(due - Clock::now()).count(), 1e-4));
  }
}

}  // namespace scanmill
