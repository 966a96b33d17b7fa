// SPDX-License-Identifier: Apache-2.0
// Checks what a person reads when no window can be opened. The one argument says what is missing,
// "display" or "opengl"; the calling script arranges it.
#include <cstdio>
#include <cstring>

#include "master/display/viewer.h"

int main(int argc, char** argv) {
  const bool wants_display = argc == 2 && std::strcmp(argv[1], "display") == 0;
  const char* const wanted = wants_display
                                 ? "no display: set DISPLAY or use `tessera-master render`"
                                 : "the viewer needs OpenGL 3.3";
  tessera::master::ViewerOptions options;
  options.title = "none";
  const auto viewer = tessera::master::Viewer::open(options);
  if (viewer.is_ok()) {
    std::puts("a window opened where none can be");
    return 1;
  }
  const std::string& line = viewer.status().message();
  std::puts(line.c_str());
  const bool is_right = viewer.status().code() == tessera::StatusCode::kUnavailable &&
                        line.find(wanted) == 0 && line.find('\n') == std::string::npos;
  return is_right ? 0 : 1;
}
