// The C interface between tessera_image and its plug-in, tessera_image_oiio.so, which alone links
// OpenImageIO.
//
// Pixels are RGB rows from the top. Strings are for a person. Nothing throws across it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tessera::master {

enum class PluginPixels : std::uint32_t { kUint8 = 0, kHalf = 1, kFloat = 2 };

struct PluginBuffer {
  unsigned char* data = nullptr;  // malloc; freed by the caller
  std::size_t size = 0;
};

extern "C" {
// Encodes `pixels` (width * height * 3) as a file of the type that `file_name` ends in (exr, png,
// hdr). Returns: 0, or 1 with a line in `error`.
using EncodeImageFunction = int (*)(const char* file_name, int width, int height, PluginPixels type,
                                    const void* pixels, PluginBuffer* out, char* error,
                                    std::size_t error_bytes);
// Decodes a file to float RGB. Returns: 0, or 1 with a line in `error`.
using ReadImageFunction = int (*)(const char* path, int* width, int* height, float** rgb,
                                  char* error, std::size_t error_bytes);
}
inline constexpr const char* kEncodeImageName = "tessera_encode_image";
inline constexpr const char* kReadImageName = "tessera_read_image";

}  // namespace tessera::master
