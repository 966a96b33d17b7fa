// SPDX-License-Identifier: Apache-2.0
// The part of tessera_image_oiio.so that the importer calls: a picture is opened, the importer
// judges its shape, and then it is decoded.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <string>

#include "master/image/oiio_plugin.h"

namespace tessera::master {
struct PluginPicture {
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;  // outlives `input`
  std::unique_ptr<OIIO::ImageInput> input;
};
}  // namespace tessera::master

namespace {

using tessera::master::PluginPicture;
using tessera::master::PluginShape;
using tessera::master::PluginTexels;

void say(char* error, std::size_t error_bytes, const std::string& text) {
  std::snprintf(error, error_bytes, "%s", text.c_str());
}

OIIO::TypeDesc type_of(PluginTexels type) {
  switch (type) {
    case PluginTexels::kUint8:
      return OIIO::TypeDesc::UINT8;
    case PluginTexels::kUint16:
      return OIIO::TypeDesc::UINT16;
    case PluginTexels::kFloat:
      return OIIO::TypeDesc::FLOAT;
  }
  return OIIO::TypeDesc::UNKNOWN;
}

std::unique_ptr<PluginPicture> open_memory(const std::string& format, const void* bytes,
                                           std::size_t size, std::string& error) {
  auto picture = std::make_unique<PluginPicture>();
  // Only the format's own reader is used: bytes of another format are refused.
  picture->input = OIIO::ImageInput::create(format);
  if (!picture->input) {
    error = OIIO::geterror();
    return nullptr;
  }
  picture->memory = std::make_unique<OIIO::Filesystem::IOMemReader>(const_cast<void*>(bytes), size);
  OIIO::ImageSpec spec, config;
  config["oiio:UnassociatedAlpha"] = 1;
  if (!picture->input->set_ioproxy(picture->memory.get()) ||
      !picture->input->open("picture." + format, spec, config)) {
    error = picture->input->geterror();
    return nullptr;
  }
  return picture;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) PluginPicture* tessera_open_picture(
    const char* path, const char* format, const void* bytes, std::size_t size, PluginShape* shape,
    char* error, std::size_t error_bytes) {
  try {
    std::unique_ptr<PluginPicture> picture;
    std::string reason;
    if (format != nullptr) {
      picture = open_memory(format, bytes, size, reason);
    } else if (auto input = OIIO::ImageInput::open(path); input) {
      picture = std::make_unique<PluginPicture>();
      picture->input = std::move(input);
    } else {
      reason = OIIO::geterror();
    }
    if (picture == nullptr) {
      say(error, error_bytes, reason);
      return nullptr;
    }
    const OIIO::ImageSpec& spec = picture->input->spec();
    *shape = {spec.width, spec.height, spec.depth, spec.nchannels,
              spec.format == OIIO::TypeDesc::UINT8};
    return picture.release();
  } catch (const std::exception& e) {
    say(error, error_bytes, e.what());
    return nullptr;
  }
}

extern "C" __attribute__((visibility("default"))) int tessera_read_picture(
    PluginPicture* picture, PluginTexels type, int channels, void* out, char* error,
    std::size_t error_bytes) {
  try {
    if (picture->input->read_image(0, 0, 0, channels, type_of(type), out)) return 0;
    say(error, error_bytes, picture->input->geterror());
  } catch (const std::exception& e) {
    say(error, error_bytes, e.what());
  }
  return 1;
}

extern "C" __attribute__((visibility("default"))) void tessera_close_picture(
    PluginPicture* picture) {
  delete picture;
}
