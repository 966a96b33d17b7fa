// SPDX-License-Identifier: Apache-2.0
#include "master/image/image_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <vector>

#include "common/base/path_suffix.h"
#include "master/image/file_channels.h"
#include "master/image/plugin_loader.h"

namespace tessera::master {
namespace {

struct FreeMalloc {
  void operator()(unsigned char* p) const { std::free(p); }
};

std::vector<float> linear_floats(const FrameImage& image) {
  std::vector<float> rgb(3 * image.pixel_count());
  decode_pixels(image.colour(), image.format, rgb);
  return rgb;
}

// Portable float map: little-endian, as the sign of the scale says, and rows from the bottom.
std::vector<std::byte> pfm_bytes(const FrameImage& image) {
  const std::vector<float> rgb = linear_floats(image);
  const std::string head =
      "PF\n" + std::to_string(image.width_px) + " " + std::to_string(image.height_px) + "\n-1.0\n";
  const std::size_t row_floats = 3 * static_cast<std::size_t>(image.width_px);
  std::vector<std::byte> bytes(head.size() + rgb.size() * sizeof(float));
  std::memcpy(bytes.data(), head.data(), head.size());
  for (std::size_t row = 0; row < static_cast<std::size_t>(image.height_px); ++row) {
    const std::size_t from_bottom = static_cast<std::size_t>(image.height_px) - 1 - row;
    std::memcpy(bytes.data() + head.size() + row * row_floats * sizeof(float),
                rgb.data() + from_bottom * row_floats, row_floats * sizeof(float));
  }
  return bytes;
}

Status encode_by_plugin(const FrameImage& image, const std::string& path, const std::string& suffix,
                        const WriteOptions& options, std::vector<std::byte>& out) {
  auto plugin = image_plugin();
  if (!plugin.is_ok()) return plugin.status();
  const auto file = file_channels(image, suffix, options.is_half_exr, options.display);
  if (!file.is_ok()) return Status(file.status().code(), path + ": " + file.status().message());
  const PluginPixelRows rows{image.width_px, image.height_px, file->channels.data(),
                             file->channels.size(), file->pixels.data()};
  std::vector<PluginAttribute> attributes;
  for (const auto& [name, value] : options.attributes)
    attributes.push_back({name.c_str(), value.c_str()});
  PluginBuffer buffer;
  char error[512] = {};
  if (plugin->encode(path.c_str(), &rows, attributes.data(), attributes.size(), &buffer, error,
                     sizeof(error)) != 0) {
    return Status::internal("cannot encode " + path + ": " + error);
  }
  const std::unique_ptr<unsigned char, FreeMalloc> owner(buffer.data);
  out.resize(buffer.size);
  std::memcpy(out.data(), buffer.data, buffer.size);
  return Status::ok();
}

// A file that is removed unless it was renamed in the end.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& path)
      : path_(path),
        file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0644)) {}
  ~TemporaryFile() {
    if (file_ >= 0) ::close(file_);
    if (!is_renamed_) ::unlink(path_.c_str());
  }
  bool is_open() const { return file_ >= 0; }
  bool write_all(const std::vector<std::byte>& bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t written = ::write(file_, bytes.data() + done, bytes.size() - done);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      done += static_cast<std::size_t>(written);
    }
    return true;
  }
  bool sync_and_close() {
    const bool is_synced = ::fsync(file_) == 0;
    const int error = errno;
    const bool is_closed = ::close(file_) == 0;
    file_ = -1;
    if (!is_synced) errno = error;
    return is_synced && is_closed;
  }
  bool rename_to(const std::string& path) {
    return is_renamed_ = ::rename(path_.c_str(), path.c_str()) == 0;
  }

 private:
  const std::string path_;
  int file_;
  bool is_renamed_ = false;
};

Status store(const std::vector<std::byte>& bytes, const std::string& path) {
  const std::filesystem::path target(path);
  const std::filesystem::path folder = target.parent_path().empty() ? "." : target.parent_path();
  const std::string temporary =
      (folder / ("." + target.filename().string() + ".part-" + std::to_string(::getpid())))
          .string();
  const auto failed = [&] {
    return Status::resource_exhausted("cannot write " + path + ": " + std::strerror(errno));
  };
  TemporaryFile file(temporary);
  if (!file.is_open() || !file.write_all(bytes) || !file.sync_and_close() || !file.rename_to(path))
    return failed();
  if (const int directory = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      directory >= 0) {
    ::fsync(directory);  // a file system that cannot sync the name is no failure
    ::close(directory);
  }
  return Status::ok();
}

}  // namespace

Status write_image(const FrameImage& image, const std::string& path, const WriteOptions& options) {
  const std::string suffix = suffix_of(path);
  std::vector<std::byte> bytes;
  if (suffix == ".pfm" && image.planes.is_empty()) {
    bytes = pfm_bytes(image);
  } else {
    TESSERA_RETURN_IF_ERROR(encode_by_plugin(image, path, suffix, options, bytes));
  }
  return store(bytes, path);
}

}  // namespace tessera::master
