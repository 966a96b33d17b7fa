// SPDX-License-Identifier: Apache-2.0
// Draws a frame into the window and reads the window back: all of OpenGL stands in picture_gl.cpp.
//
// The picture is one triangle that covers the letterbox rectangle; float and half frames stay
// linear in the texture and are exposed, bent and sRGB-encoded in the fragment shader, kDisplay8 is
// shown as it is. A second texture holds one colour per tile. Scaled up, the picture is
// interpolated between the middles of its pixels, as it is shown and not as it was computed: light
// that is far brighter than white would else swallow its neighbours. At its own size it is shown to
// the bit.
//
// Threads. Main thread, with the window's context current from construction to destruction.
#pragma once

#include <memory>

#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "master/display/picture_layout.h"

namespace tessera::master {

class PictureGl {
 public:
  // Requires: a current context of at least OpenGL 3.3. Returns: kUnavailable with the driver's
  // words.
  static Result<std::unique_ptr<PictureGl>> create();
  virtual ~PictureGl() = default;

  // Greatest side of a picture that show() takes, pixels.
  virtual int side_max_px() const = 0;

  // Copies a frame's pixels to the display, to fill the place of a picture of the size `stands_for`
  // (sides of 0: the frame's own). Returns: kResourceExhausted when the frame is too large,
  // kInternal when its bytes do not fit its size; then the picture before stays.
  virtual Status show(const FrameImage& image, PixelSize stands_for) = 0;

  // How linear pixels are shown from the next draw() on; display8 is shown as it is.
  virtual void set_display(const DisplayTransform& display) = 0;

  // Clears the window and draws the picture (if any) letterboxed. Requires: sides at least 1.
  virtual void draw(PixelSize window, bool tints_tiles) = 0;

  // Reads the window as drawn: kDisplay8, rows from the top. Must be called before swap().
  virtual FrameImage read_back(PixelSize window) = 0;
};

}  // namespace tessera::master
