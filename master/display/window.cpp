// SPDX-License-Identifier: Apache-2.0
#include "master/display/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <utility>

#include "common/base/log.h"

namespace tessera::master {

namespace {

constexpr int kGlMajor = 3, kGlMinor = 3;

// GLFW reports through a callback without user data; the main thread alone opens windows.
std::string& error_text() {
  static std::string text;
  return text;
}

void on_error(int /*code*/, const char* description) {
  std::string line = description;
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::string& text = error_text();
  if (text.size() < 1000) text += (text.empty() ? "" : "; ") + line;
}

std::string in_brackets(const std::string& text) { return text.empty() ? "" : " (" + text + ")"; }

// What OpenGL the display offers when asked for nothing in particular, such as "2.1"; empty: none.
std::string offered_gl_version() {
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  GLFWwindow* probe = glfwCreateWindow(16, 16, "", nullptr, nullptr);
  if (probe == nullptr) return "";
  std::string version = std::to_string(glfwGetWindowAttrib(probe, GLFW_CONTEXT_VERSION_MAJOR)) +
                        "." +
                        std::to_string(glfwGetWindowAttrib(probe, GLFW_CONTEXT_VERSION_MINOR));
  glfwDestroyWindow(probe);
  return version;
}

struct KeyName {
  int glfw;
  Key key;
};
constexpr KeyName kKeyNames[] = {
    {GLFW_KEY_W, Key::kW},
    {GLFW_KEY_A, Key::kA},
    {GLFW_KEY_S, Key::kS},
    {GLFW_KEY_D, Key::kD},
    {GLFW_KEY_Q, Key::kQ},
    {GLFW_KEY_E, Key::kE},
    {GLFW_KEY_H, Key::kH},
    {GLFW_KEY_O, Key::kO},
    {GLFW_KEY_L, Key::kL},
    {GLFW_KEY_T, Key::kT},
    {GLFW_KEY_R, Key::kR},
    {GLFW_KEY_F, Key::kF},
    {GLFW_KEY_C, Key::kC},
    {GLFW_KEY_F12, Key::kF12},
    {GLFW_KEY_SPACE, Key::kSpace},
    {GLFW_KEY_PERIOD, Key::kPeriod},
    {GLFW_KEY_COMMA, Key::kComma},
    {GLFW_KEY_ESCAPE, Key::kEscape},
    {GLFW_KEY_V, Key::kV},
    {GLFW_KEY_X, Key::kX},
    {GLFW_KEY_LEFT_BRACKET, Key::kLeftBracket},
    {GLFW_KEY_RIGHT_BRACKET, Key::kRightBracket},
};

Key to_key(int key) {
  for (const KeyName& name : kKeyNames) {
    if (name.glfw == key) return name.key;
  }
  return Key::kOther;
}

}  // namespace

struct Window::Callbacks {
  static void push(GLFWwindow* handle, const InputEvent& event) {
    static_cast<Window*>(glfwGetWindowUserPointer(handle))->events_.push_back(event);
  }

  static void on_key(GLFWwindow* handle, int key, int /*scancode*/, int action, int mods) {
    if (action == GLFW_REPEAT) return;
    InputEvent event;
    event.kind = action == GLFW_PRESS ? InputEvent::Kind::kKeyDown : InputEvent::Kind::kKeyUp;
    event.key = to_key(key);
    // GLFW's modifiers on X11 are those before the event: a shift key's own press counts by hand.
    const bool is_shift = key == GLFW_KEY_LEFT_SHIFT || key == GLFW_KEY_RIGHT_SHIFT;
    event.has_shift = is_shift ? action == GLFW_PRESS : (mods & GLFW_MOD_SHIFT) != 0;
    event.has_control = (mods & GLFW_MOD_CONTROL) != 0;
    push(handle, event);
  }

  static void on_button(GLFWwindow* handle, int button, int action, int mods) {
    InputEvent event;
    event.kind = action == GLFW_PRESS ? InputEvent::Kind::kButtonDown : InputEvent::Kind::kButtonUp;
    event.button = button == GLFW_MOUSE_BUTTON_LEFT     ? MouseButton::kLeft
                   : button == GLFW_MOUSE_BUTTON_MIDDLE ? MouseButton::kMiddle
                                                        : MouseButton::kOther;
    event.has_shift = (mods & GLFW_MOD_SHIFT) != 0;
    push(handle, event);
  }

  // GLFW speaks of screen coordinates; a display with scaling has more pixels than those.
  static void on_move(GLFWwindow* handle, double x, double y) {
    int window_width = 0, window_height = 0, width_px = 0, height_px = 0;
    glfwGetWindowSize(handle, &window_width, &window_height);
    glfwGetFramebufferSize(handle, &width_px, &height_px);
    if (window_width <= 0 || window_height <= 0) return;
    InputEvent event;
    event.kind = InputEvent::Kind::kMove;
    event.x_px = x * width_px / window_width;
    event.y_px = y * height_px / window_height;
    push(handle, event);
  }

  static void on_scroll(GLFWwindow* handle, double /*x*/, double y) {
    InputEvent event;
    event.kind = InputEvent::Kind::kScroll;
    event.scroll_steps = y;
    push(handle, event);
  }

  static void on_focus(GLFWwindow* handle, int is_focused) {
    if (is_focused == GLFW_FALSE) push(handle, InputEvent{});
  }
};

namespace {

Status start_glfw() {
  error_text().clear();
  glfwSetErrorCallback(on_error);
  if (glfwInit() != GLFW_FALSE) return Status::ok();
  return Status::unavailable("no display: set DISPLAY or use `tessera-master render`" +
                             in_brackets(error_text()));
}

}  // namespace

Status Window::check_display() {
  const Status status = start_glfw();
  if (status.is_ok()) glfwTerminate();
  return status;
}

Result<std::unique_ptr<Window>> Window::open(const std::string& title, PixelSize size) {
  TESSERA_RETURN_IF_ERROR(start_glfw());
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, kGlMajor);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, kGlMinor);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  GLFWwindow* handle =
      glfwCreateWindow(size.width_px, size.height_px, title.c_str(), nullptr, nullptr);
  if (handle == nullptr) {
    const std::string reason = error_text();
    const std::string offered = offered_gl_version();
    glfwTerminate();
    const std::string found =
        offered.empty() ? "this display offers no OpenGL" : "this display offers OpenGL " + offered;
    return Status::unavailable("the viewer needs OpenGL 3.3, " + found +
                               ": update the graphics driver or use `tessera-master render`" +
                               in_brackets(reason));
  }
  glfwMakeContextCurrent(handle);
  glfwSwapInterval(1);
  error_text().clear();
  return std::unique_ptr<Window>(new Window(handle));
}

Window::Window(GLFWwindow* handle) : handle_(handle) {
  glfwSetWindowUserPointer(handle, this);
  glfwSetKeyCallback(handle, Callbacks::on_key);
  glfwSetMouseButtonCallback(handle, Callbacks::on_button);
  glfwSetCursorPosCallback(handle, Callbacks::on_move);
  glfwSetScrollCallback(handle, Callbacks::on_scroll);
  glfwSetWindowFocusCallback(handle, Callbacks::on_focus);
}

Window::~Window() {
  glfwDestroyWindow(handle_);
  glfwTerminate();
}

std::vector<InputEvent> Window::wait_events(double seconds) {
  if (seconds > 0) {
    glfwWaitEventsTimeout(seconds);
  } else {
    glfwPollEvents();
  }
  if (!error_text().empty()) {
    log_warn("window", std::exchange(error_text(), {}));
  }
  return std::exchange(events_, {});
}

void Window::wake() { glfwPostEmptyEvent(); }

PixelSize Window::framebuffer_size() const {
  PixelSize size;
  glfwGetFramebufferSize(handle_, &size.width_px, &size.height_px);
  return size;
}

bool Window::is_close_wanted() const { return glfwWindowShouldClose(handle_) != GLFW_FALSE; }

double Window::refresh_seconds() const {
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  return mode != nullptr && mode->refreshRate > 0 ? 1.0 / mode->refreshRate : 1.0 / 60;
}

void Window::swap() { glfwSwapBuffers(handle_); }

void Window::set_clipboard(const std::string& text) {
  glfwSetClipboardString(handle_, text.c_str());
}

double Window::now_seconds() { return glfwGetTime(); }

}  // namespace tessera::master
