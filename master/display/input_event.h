// SPDX-License-Identifier: Apache-2.0
// What a person did at the window, free of any window library, so that the controls can be tested
// without one.
//
// Positions are in framebuffer pixels, x to the right, y downwards, origin at the top left.
//
// Threads. Plain values.
#pragma once

namespace tessera::master {

enum class Key {
  kOther,
  kW,
  kA,
  kS,
  kD,
  kQ,
  kE,  // fly
  kH,
  kO,
  kT,
  kL,
  kR,
  kF,
  kC,
  kV,
  kX,
  kLeftBracket,
  kRightBracket,
  kF12,
  kSpace,
  kPeriod,
  kComma,
  kEscape,  // commands: key_map.h
};

enum class MouseButton { kOther, kLeft, kMiddle };

struct InputEvent {
  enum class Kind {
    kKeyDown,
    kKeyUp,  // key, has_shift, has_control
    kButtonDown,
    kButtonUp,   // button, has_shift
    kMove,       // x_px, y_px
    kScroll,     // scroll_steps: away from the person is positive
    kFocusLost,  // every key and button counts as released
  };
  Kind kind = Kind::kFocusLost;
  Key key = Key::kOther;
  MouseButton button = MouseButton::kOther;
  bool has_shift = false, has_control = false;
  double x_px = 0, y_px = 0;
  double scroll_steps = 0;
};

}  // namespace tessera::master
