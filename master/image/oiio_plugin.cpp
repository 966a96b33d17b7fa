// SPDX-License-Identifier: Apache-2.0
// Built as tessera_image_oiio.so, which is loaded when the first picture is written or read. This
// part writes.
#include "master/image/oiio_plugin.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <vector>

namespace {

using tessera::master::PluginAttribute;
using tessera::master::PluginChannel;
using tessera::master::PluginPixels;
using tessera::master::PluginRows;

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

// What 8 bits and quality 95 lose together is less than one step of the display.
constexpr const char* kJpegQuality = "jpeg:95";
constexpr const char* kJpegText = "ImageDescription";

// Returns: the type of all channels where they agree, otherwise UNKNOWN, which means that each has
// the type that the spec says.
OIIO::TypeDesc describe_channels(const PluginRows& rows, OIIO::ImageSpec& spec) {
  bool is_alike = true;
  spec.channelnames.clear();
  for (std::size_t c = 0; c < rows.channel_count; ++c) {
    const PluginChannel& channel = rows.channels[c];
    spec.channelnames.emplace_back(channel.name);
    spec.channelformats.push_back(type_of(channel.type));
    is_alike = is_alike && channel.type == rows.channels[0].type;
    if (spec.channelnames.back() == "A") spec.alpha_channel = static_cast<int>(c);
    if (spec.channelnames.back() == "Z") spec.z_channel = static_cast<int>(c);
  }
  if (!is_alike) return OIIO::TypeDesc::UNKNOWN;
  spec.channelformats.clear();
  return spec.format;
}

// A file that notes why the system did not take bytes, which no writer of OpenImageIO says.
class NotingFile final : public OIIO::Filesystem::IOFile {
 public:
  explicit NotingFile(FILE* file) : IOFile(file, Write) {}
  std::size_t write(const void* buffer, std::size_t size) override {
    return noted(IOFile::write(buffer, size), size);
  }
  std::size_t pwrite(const void* buffer, std::size_t size, std::int64_t offset) override {
    return noted(IOFile::pwrite(buffer, size, offset), size);
  }
  int error() const { return error_; }  // an errno, 0: none

 private:
  std::size_t noted(std::size_t written, std::size_t size) {
    if (written < size && error_ == 0) error_ = errno;
    return written;
  }
  int error_ = 0;
};

struct CloseFile {
  void operator()(FILE* file) const { std::fclose(file); }
};

}  // namespace

// Members are destroyed from the last to the first: the writer flushes into the proxy.
struct tessera::master::PluginFile {
  explicit PluginFile(FILE* opened) : file(opened), proxy(opened) {}

  std::unique_ptr<FILE, CloseFile> file;
  NotingFile proxy;
  std::unique_ptr<OIIO::ImageOutput> output;
  OIIO::TypeDesc kept_as;
  int height = 0, rows_written = 0;

  int failed(char* error, std::size_t error_bytes) {
    const std::string reason = output->geterror();
    return fail(error, error_bytes, proxy.error() != 0 ? std::strerror(proxy.error()) : reason);
  }
};

namespace {

using tessera::master::PluginFile;

std::unique_ptr<PluginFile> begin(const char* file_name, int descriptor, const PluginRows& rows,
                                  const PluginAttribute* attributes, std::size_t attribute_count,
                                  char* error, std::size_t error_bytes) {
  const int own = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  FILE* const opened = own < 0 ? nullptr : ::fdopen(own, "wb");
  if (opened == nullptr) {
    fail(error, error_bytes, std::strerror(errno));
    if (own >= 0) ::close(own);
    return nullptr;
  }
  auto file = std::make_unique<PluginFile>(opened);
  file->height = rows.height;
  file->output = OIIO::ImageOutput::create(file_name, &file->proxy);
  if (!file->output) {
    fail(error, error_bytes, OIIO::geterror());
    return nullptr;
  }
  const PluginPixels type = rows.channels[0].type;
  OIIO::ImageSpec spec(rows.width, rows.height, static_cast<int>(rows.channel_count),
                       type_of(type));
  file->kept_as = describe_channels(rows, spec);
  const bool is_jpeg = file->output->format_name() == std::string("jpeg");
  spec.attribute("compression", is_jpeg ? kJpegQuality : "zip");
  std::string description;  // JPEG has room for one text: a line for each
  for (std::size_t i = 0; i < attribute_count; ++i) {
    if (!is_jpeg) spec.attribute(attributes[i].name, attributes[i].value);
    description += std::string(attributes[i].name) + "=" + attributes[i].value + "\n";
  }
  if (is_jpeg && !description.empty()) spec.attribute(kJpegText, description);
  if (type == PluginPixels::kUint8) {
    spec.attribute("oiio:ColorSpace", "sRGB");
    if (spec.alpha_channel >= 0) spec.attribute("oiio:UnassociatedAlpha", 1);
  }
  if (file->output->open(file_name, spec)) return file;
  file->failed(error, error_bytes);
  return nullptr;
}

int write_rows(PluginFile& file, int first_row, int row_count, const void* pixels, char* error,
               std::size_t error_bytes) {
  const bool is_written =
      file.output->write_scanlines(first_row, first_row + row_count, 0, file.kept_as, pixels);
  if (!is_written || file.proxy.error() != 0) return file.failed(error, error_bytes);
  file.rows_written += row_count;
  return 0;
}

int end(PluginFile& file, char* error, std::size_t error_bytes) {
  const bool is_whole = file.rows_written == file.height;
  const bool is_closed = file.output->close();
  if (!is_whole) return fail(error, error_bytes, "rows are missing");
  if (!is_closed || file.proxy.error() != 0) return file.failed(error, error_bytes);
  if (std::fflush(file.file.get()) != 0) return fail(error, error_bytes, std::strerror(errno));
  return 0;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) PluginFile* tessera_begin_image(
    const char* file_name, int descriptor, const PluginRows* rows,
    const PluginAttribute* attributes, std::size_t attribute_count, char* error,
    std::size_t error_bytes) {
  try {
    return begin(file_name, descriptor, *rows, attributes, attribute_count, error, error_bytes)
        .release();
  } catch (const std::exception& e) {
    fail(error, error_bytes, e.what());
    return nullptr;
  }
}

extern "C" __attribute__((visibility("default"))) int tessera_write_rows(
    PluginFile* file, int first_row, int row_count, const void* pixels, char* error,
    std::size_t error_bytes) {
  try {
    return write_rows(*file, first_row, row_count, pixels, error, error_bytes);
  } catch (const std::exception& e) {
    return fail(error, error_bytes, e.what());
  }
}

extern "C" __attribute__((visibility("default"))) int tessera_end_image(PluginFile* file,
                                                                        char* error,
                                                                        std::size_t error_bytes) {
  const std::unique_ptr<PluginFile> owner(file);
  try {
    return end(*file, error, error_bytes);
  } catch (const std::exception& e) {
    return fail(error, error_bytes, e.what());
  }
}
