// Built as tessera_image_oiio.so; loaded when the first picture is written or read.
#include "master/image/oiio_plugin.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

namespace {

using tessera::master::PluginBuffer;
using tessera::master::PluginPixels;

int fail(char* error, std::size_t error_bytes, const std::string& text) {
  std::snprintf(error, error_bytes, "%s", text.c_str());
  return 1;
}

OIIO::TypeDesc type_of(PluginPixels type) {
  switch (type) {
    case PluginPixels::kUint8:
      return OIIO::TypeDesc::UINT8;
    case PluginPixels::kHalf:
      return OIIO::TypeDesc::HALF;
    case PluginPixels::kFloat:
      return OIIO::TypeDesc::FLOAT;
  }
  return OIIO::TypeDesc::UNKNOWN;
}

int encode(const char* file_name, int width, int height, PluginPixels type, const void* pixels,
           PluginBuffer* out, char* error, std::size_t error_bytes) {
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  auto output = OIIO::ImageOutput::create(file_name, &memory);
  if (!output) return fail(error, error_bytes, OIIO::geterror());
  OIIO::ImageSpec spec(width, height, 3, type_of(type));
  spec.attribute("compression", "zip");
  if (type == PluginPixels::kUint8) spec.attribute("oiio:ColorSpace", "sRGB");
  if (!output->open(file_name, spec) || !output->write_image(type_of(type), pixels) ||
      !output->close()) {
    return fail(error, error_bytes, output->geterror());
  }
  out->data = static_cast<unsigned char*>(std::malloc(bytes.size() + 1));
  if (out->data == nullptr) return fail(error, error_bytes, "out of memory");
  out->size = bytes.size();
  if (!bytes.empty()) std::memcpy(out->data, bytes.data(), bytes.size());
  return 0;
}

int read(const char* path, int* width, int* height, float** rgb, char* error,
         std::size_t error_bytes) {
  auto input = OIIO::ImageInput::open(path);
  if (!input) return fail(error, error_bytes, OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  *width = spec.width;
  *height = spec.height;
  const std::size_t pixel_count =
      static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  const std::size_t channels = static_cast<std::size_t>(spec.nchannels);
  std::vector<float> all(pixel_count * channels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, all.data())) {
    return fail(error, error_bytes, input->geterror());
  }
  *rgb = static_cast<float*>(std::malloc(pixel_count * 3 * sizeof(float) + 1));
  if (*rgb == nullptr) return fail(error, error_bytes, "out of memory");
  for (std::size_t i = 0; i < pixel_count; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      (*rgb)[3 * i + c] = all[i * channels + (channels >= 3 ? c : 0)];
  }
  return 0;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) int tessera_encode_image(
    const char* file_name, int width, int height, PluginPixels type, const void* pixels,
    PluginBuffer* out, char* error, std::size_t error_bytes) {
  try {
    return encode(file_name, width, height, type, pixels, out, error, error_bytes);
  } catch (const std::exception& e) {
    return fail(error, error_bytes, e.what());
  }
}

extern "C" __attribute__((visibility("default"))) int tessera_read_image(const char* path,
                                                                         int* width, int* height,
                                                                         float** rgb, char* error,
                                                                         std::size_t error_bytes) {
  try {
    return read(path, width, height, rgb, error, error_bytes);
  } catch (const std::exception& e) {
    return fail(error, error_bytes, e.what());
  }
}
