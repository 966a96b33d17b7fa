// SPDX-License-Identifier: Apache-2.0
// The C interface between tessera_image and its plug-in, tessera_image_oiio.so, which alone links
// OpenImageIO.
//
// Strings are for a person. Nothing throws across it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tessera::master {

enum class PluginPixels : std::uint32_t { kUint8 = 0, kHalf = 1, kFloat = 2 };

// One channel of a picture: its name as EXR has it, and how its numbers are kept.
struct PluginChannel {
  const char* name;
  PluginPixels type;
};
// Rows of pixels from the top; the channels of a pixel lie side by side, packed, each in its own
// type. The first three are R, G, B; a fourth that is named A is alpha: colour is then
// premultiplied where it is half or float, and not where it is uint8.
struct PluginRows {
  int width = 0, height = 0;  // of the picture
  const PluginChannel* channels = nullptr;
  std::size_t channel_count = 0;
};

// An attribute that a picture file has. Strings live as long as the call.
struct PluginAttribute {
  const char* name;
  const char* value;
};

// A picture that is being written to a file.
struct PluginFile;

extern "C" {
// Begins a file of the type that `file_name` ends in (exr, png, jpg, hdr), with the attributes that
// this type can hold, and writes it to `descriptor`, which stays the caller's and is empty. All
// rows follow, in order, then the end. Requires: the type can hold the channels. Returns: null with
// a line in `error`.
using BeginImageFunction = PluginFile* (*)(const char* file_name, int descriptor,
                                           const PluginRows* rows,
                                           const PluginAttribute* attributes,
                                           std::size_t attribute_count, char* error,
                                           std::size_t error_bytes);
// Returns, as the end does: 0, or 1 with a line in `error`: why the system did not take the bytes,
// where that is the reason.
using WriteRowsFunction = int (*)(PluginFile*, int first_row, int row_count, const void* pixels,
                                  char* error, std::size_t error_bytes);
// Completes the file where all rows were written; in any case PluginFile is gone afterwards.
using EndImageFunction = int (*)(PluginFile*, char* error, std::size_t error_bytes);
// An opened picture that a scene names. The importer judges its shape before any pixel is decoded.
struct PluginPicture;
struct PluginShape {
  int width = 0, height = 0, depth = 0, channels = 0;
  bool is_uint8 = false;
};
enum class PluginTexels : std::uint32_t { kUint8 = 0, kUint16 = 1, kFloat = 2 };
// Opens the file `path` by the reader of OpenImageIO that is named, and no other; where `bytes` is
// not null, opens those instead, with colours as they are stored; they outlive the picture.
// Returns: null with a line in `error`.
using OpenPictureFunction = PluginPicture* (*)(const char* path, const char* reader,
                                               const void* bytes, std::size_t size,
                                               PluginShape* shape, char* error,
                                               std::size_t error_bytes);
// Reads the first `channels` of all pixels, each pixel to a place of `stride` texels.
// Returns: 0, or 1 with a line in `error`.
using ReadPictureFunction = int (*)(PluginPicture*, PluginTexels type, int channels, int stride,
                                    void* out, char* error, std::size_t error_bytes);
// Makes values linear by the encoding that the file states, else as sRGB for integers and as linear
// for floats. Returns: 0 where they were linear.
using MakeLinearFunction = int (*)(const PluginPicture*, float* values, std::size_t count);
// Text attributes, "name=value" each ended by a 0, and a 0 behind the last; from malloc, or null.
using AttributesFunction = char* (*)(const PluginPicture*);
using ClosePictureFunction = void (*)(PluginPicture*);
}
inline constexpr const char* kBeginImageName = "tessera_begin_image";
inline constexpr const char* kWriteRowsName = "tessera_write_rows";
inline constexpr const char* kEndImageName = "tessera_end_image";
inline constexpr const char* kOpenPictureName = "tessera_open_picture";
inline constexpr const char* kReadPictureName = "tessera_read_picture";
inline constexpr const char* kMakeLinearName = "tessera_make_linear";
inline constexpr const char* kAttributesName = "tessera_picture_attributes";
inline constexpr const char* kClosePictureName = "tessera_close_picture";

}  // namespace tessera::master
