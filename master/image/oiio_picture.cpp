// SPDX-License-Identifier: Apache-2.0
// The part of tessera_image_oiio.so that the importer calls: a picture is opened, the importer
// judges its shape, and then it is decoded.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
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

// Only the format's own reader is used: bytes of another format are refused.
std::unique_ptr<PluginPicture> open_picture(const char* path, const std::string& reader,
                                            const void* bytes, std::size_t size,
                                            std::string& error) {
  auto picture = std::make_unique<PluginPicture>();
  picture->input = OIIO::ImageInput::create(reader);
  if (!picture->input) {
    error = OIIO::geterror();
    return nullptr;
  }
  OIIO::ImageSpec spec, config;
  if (bytes == nullptr) {
    if (picture->input->open(path, spec, config)) return picture;
    error = picture->input->geterror();
    return nullptr;
  }
  picture->memory = std::make_unique<OIIO::Filesystem::IOMemReader>(const_cast<void*>(bytes), size);
  config["oiio:UnassociatedAlpha"] = 1;
  if (!picture->input->set_ioproxy(picture->memory.get()) ||
      !picture->input->open("picture." + reader, spec, config)) {
    error = picture->input->geterror();
    return nullptr;
  }
  return picture;
}

// What 8-bit files of this program have their attributes in.
constexpr const char* kJpegText = "ImageDescription";

float linear_of_srgb(float value) {
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

bool linearise(const OIIO::ImageSpec& spec, float* values, std::size_t count) {
  const std::string space = spec.get_string_attribute("oiio:ColorSpace");
  const float gamma = spec.get_float_attribute("oiio:Gamma", 0);
  const bool is_integer = !spec.format.is_floating_point();
  if (OIIO::Strutil::iequals(space, "linear")) return false;
  if (OIIO::Strutil::istarts_with(space, "gamma") && gamma > 0) {
    for (std::size_t i = 0; i < count; ++i) values[i] = std::pow(std::max(values[i], 0.0f), gamma);
  } else if (OIIO::Strutil::iequals(space, "sRGB") || is_integer) {
    for (std::size_t i = 0; i < count; ++i) values[i] = linear_of_srgb(values[i]);
  } else {
    return false;
  }
  return true;
}

char* attributes_of(const OIIO::ImageSpec& spec) {
  std::string all;
  for (const OIIO::ParamValue& p : spec.extra_attribs) {
    if (p.type() != OIIO::TypeDesc::STRING) continue;
    std::string text = p.name().string() + "=" + p.get_string();
    if (p.name() == kJpegText) {
      text = p.get_string();
      std::replace(text.begin(), text.end(), '\n', '\0');
      while (!text.empty() && text.back() == '\0') text.pop_back();
      if (text.find(std::string(2, '\0')) != text.npos) continue;  // an empty text ends the list
    }
    if (!text.empty()) all.append(text).push_back('\0');
  }
  all.push_back('\0');
  auto* const copy = static_cast<char*>(std::malloc(all.size()));
  if (copy != nullptr) std::memcpy(copy, all.data(), all.size());
  return copy;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) PluginPicture* tessera_open_picture(
    const char* path, const char* reader, const void* bytes, std::size_t size, PluginShape* shape,
    char* error, std::size_t error_bytes) {
  try {
    std::string reason;
    auto picture = open_picture(path, reader, bytes, size, reason);
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
    PluginPicture* picture, PluginTexels type, int channels, int stride, void* out, char* error,
    std::size_t error_bytes) {
  try {
    const OIIO::TypeDesc texel = type_of(type);
    const auto stride_bytes = static_cast<OIIO::stride_t>(texel.size()) * stride;
    if (picture->input->read_image(0, 0, 0, channels, texel, out, stride_bytes)) return 0;
    say(error, error_bytes, picture->input->geterror());
  } catch (const std::exception& e) {
    say(error, error_bytes, e.what());
  }
  return 1;
}

extern "C" __attribute__((visibility("default"))) int tessera_make_linear(
    const PluginPicture* picture, float* values, std::size_t count) {
  return linearise(picture->input->spec(), values, count) ? 1 : 0;
}

extern "C" __attribute__((visibility("default"))) char* tessera_picture_attributes(
    const PluginPicture* picture) {
  try {
    return attributes_of(picture->input->spec());
  } catch (const std::exception&) {
    return nullptr;  // out of memory
  }
}

extern "C" __attribute__((visibility("default"))) void tessera_close_picture(
    PluginPicture* picture) {
  delete picture;
}
