// SPDX-License-Identifier: Apache-2.0
// The window and its events: all of GLFW stands in window.cpp.
//
// Threads. Main thread; wake() may be called by any thread while the object lives.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "master/display/input_event.h"
#include "master/display/picture_layout.h"

struct GLFWwindow;

namespace tessera::master {

class Window {
 public:
  // Whether windows can be opened at all. Returns: kUnavailable, one line.
  static Status check_display();
  // Opens a window with a current OpenGL 3.3 core context. Returns: kUnavailable, one line.
  static Result<std::unique_ptr<Window>> open(const std::string& title, PixelSize size);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // Waits for events at most `seconds` (0: not at all); returns those that came.
  std::vector<InputEvent> wait_events(double seconds);
  void wake();  // ends a wait

  PixelSize framebuffer_size() const;
  bool is_close_wanted() const;
  double refresh_seconds() const;  // of the display; 1/60 when it does not say
  void swap();
  void set_clipboard(const std::string& text);  // kept while the window lives, on most systems

  static double now_seconds();                    // monotonic
  GLFWwindow* handle() const { return handle_; }  // for the overlay's backend

 private:
  explicit Window(GLFWwindow* handle);
  struct Callbacks;

  GLFWwindow* handle_;
  std::vector<InputEvent> events_;
};

}  // namespace tessera::master
