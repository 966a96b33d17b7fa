// SPDX-License-Identifier: Apache-2.0
// Which key does what: the one table that the controls look into and that the help prints. A new
// key is a row here, a name in input_event.h and window.cpp when it has none, and a case in
// viewer.cpp.
//
// Threads. Plain values. Invariant. A key stands in one row at most.
#pragma once

#include <span>
#include <string_view>

#include "master/display/input_event.h"

namespace tessera::master {

enum class ViewerCommand {
  kNone,
  kFitScene,  // CameraControls carries out this and the next
  kResetCamera,
  kSavePicture,
  kCopyCamera,
  kTogglePause,
  kStepOn,
  kStepBack,
  kDarker,
  kBrighter,
  kNextCurve,
  kResetExposure,
  kToggleTint,
  kToggleSlaves,
  kToggleOverlay,
  kToggleHelp,
  kQuit,
};

struct KeyBinding {
  Key key = Key::kOther;  // kOther: the row only tells of the mouse, or of keys that are held down
  ViewerCommand command = ViewerCommand::kNone;
  std::string_view label;    // the key's name in the help
  std::string_view meaning;  // what the key does, in the help
};

// All bindings, in the order of the help.
std::span<const KeyBinding> key_bindings();

// What a key that goes down means. Ctrl + Q quits; with Ctrl, no other key means anything.
ViewerCommand command_of(Key key, bool has_control);

}  // namespace tessera::master
