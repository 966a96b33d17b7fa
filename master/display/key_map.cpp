// SPDX-License-Identifier: Apache-2.0
#include "master/display/key_map.h"

#include <array>

namespace tessera::master {
namespace {

constexpr auto kBindings = std::to_array<KeyBinding>({
    {Key::kOther, ViewerCommand::kNone, "left drag", "orbit"},
    {Key::kOther, ViewerCommand::kNone, "middle drag, shift + left drag", "pan"},
    {Key::kOther, ViewerCommand::kNone, "wheel", "zoom"},
    {Key::kOther, ViewerCommand::kNone, "w s   a d", "fly forward, back   left, right"},
    {Key::kOther, ViewerCommand::kNone, "e q", "fly up, down"},
    {Key::kOther, ViewerCommand::kNone, "shift + fly key", "faster"},
    {Key::kF, ViewerCommand::kFitScene, "f", "fit the scene"},
    {Key::kR, ViewerCommand::kResetCamera, "r", "reset the camera"},
    {Key::kC, ViewerCommand::kCopyCamera, "c", "print and copy the camera"},
    {Key::kSpace, ViewerCommand::kTogglePause, "space", "pause, play"},
    {Key::kPeriod, ViewerCommand::kStepOn, ".", "pause, and one frame on"},
    {Key::kComma, ViewerCommand::kStepBack, ",", "pause, and one frame back"},
    {Key::kF12, ViewerCommand::kSavePicture, "F12", "save the picture as EXR and PNG"},
    {Key::kLeftBracket, ViewerCommand::kDarker, "[", "a third of a stop darker"},
    {Key::kRightBracket, ViewerCommand::kBrighter, "]", "a third of a stop brighter"},
    {Key::kV, ViewerCommand::kNextCurve, "v", "next tone curve"},
    {Key::kX, ViewerCommand::kResetExposure, "x", "take back changes of exposure"},
    {Key::kT, ViewerCommand::kToggleTint, "t", "tint tiles by slave"},
    {Key::kL, ViewerCommand::kToggleSlaves, "l", "list of slaves on, off"},
    {Key::kO, ViewerCommand::kToggleOverlay, "o", "overlay on, off"},
    {Key::kH, ViewerCommand::kToggleHelp, "h", "this help on, off"},
    {Key::kEscape, ViewerCommand::kQuit, "Esc, Ctrl + Q", "quit"},
});

}  // namespace

std::span<const KeyBinding> key_bindings() { return kBindings; }

ViewerCommand command_of(Key key, bool has_control) {
  if (has_control) return key == Key::kQ ? ViewerCommand::kQuit : ViewerCommand::kNone;
  if (key == Key::kOther) return ViewerCommand::kNone;
  for (const KeyBinding& binding : kBindings) {
    if (binding.key == key) return binding.command;
  }
  return ViewerCommand::kNone;
}

}  // namespace tessera::master
