// SPDX-License-Identifier: Apache-2.0
#include "master/image/image_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <span>
#include <vector>

#include "common/base/path_suffix.h"
#include "master/image/file_channels.h"
#include "master/image/plugin_loader.h"

namespace tessera::master {
namespace {

// Rows that are decoded, arranged and handed on at a time: the chunks of an EXR have 16 rows, and
// OpenEXR packs several at once. They take 100 MB of the widest picture with all planes.
constexpr int kBandRows = 64;

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
  int descriptor() const { return file_; }
  bool write_all(std::span<const std::byte> bytes) {
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

// Writes a portable float map: little-endian, as the sign of the scale says, and rows from the
// bottom. Returns: false with errno.
bool write_pfm(const FrameImage& image, TemporaryFile& file) {
  const std::string head =
      "PF\n" + std::to_string(image.width_px) + " " + std::to_string(image.height_px) + "\n-1.0\n";
  if (!file.write_all(std::as_bytes(std::span(head)))) return false;
  const std::size_t row_bytes =
      static_cast<std::size_t>(image.width_px) * image.layout().colour_bytes();
  std::vector<float> row(3 * static_cast<std::size_t>(image.width_px));
  for (int y = image.height_px; y-- > 0;) {
    decode_pixels(image.colour().subspan(static_cast<std::size_t>(y) * row_bytes, row_bytes),
                  image.format, row);
    if (!file.write_all(std::as_bytes(std::span(row)))) return false;
  }
  return true;
}

// Returns: one line with file and reason.
Status write_by_plugin(const FrameImage& image, const std::string& path, FileChannels& channels,
                       const ImagePlugin& plugin, const WriteOptions& options,
                       const TemporaryFile& file) {
  const PluginRows rows{image.width_px, image.height_px, channels.channels().data(),
                        channels.channels().size()};
  std::vector<PluginAttribute> attributes;
  for (const auto& [name, value] : options.attributes)
    attributes.push_back({name.c_str(), value.c_str()});
  char error[512] = {}, end_error[512] = {};
  const auto failed = [&path](const char* why) {
    return Status::resource_exhausted("cannot write " + path + ": " + why);
  };
  PluginFile* const begun =
      plugin.begin_image(path.c_str(), file.descriptor(), &rows, attributes.data(),
                         attributes.size(), error, sizeof(error));
  if (begun == nullptr) return failed(error);
  bool is_good = true;
  for (int row = 0; is_good && row < image.height_px; row += kBandRows) {
    const int count = std::min(kBandRows, image.height_px - row);
    is_good = plugin.write_rows(begun, row, count, channels.rows(row, count).data(), error,
                                sizeof(error)) == 0;
  }
  const bool is_ended = plugin.end_image(begun, end_error, sizeof(end_error)) == 0;
  if (!is_good) return failed(error);
  return is_ended ? Status::ok() : failed(end_error);
}

}  // namespace

Status write_image(const FrameImage& image, const std::string& path, const WriteOptions& options) {
  const std::string suffix = suffix_of(path);
  const auto failed = [&] {
    return Status::resource_exhausted("cannot write " + path + ": " + std::strerror(errno));
  };
  const bool is_pfm = suffix == ".pfm" && image.planes.is_empty();
  auto plugin = is_pfm ? Result<ImagePlugin>(ImagePlugin{}) : image_plugin();
  if (!plugin.is_ok()) return plugin.status();
  auto channels = file_channels(image, suffix, options.is_half_exr, options.display);
  if (!channels.is_ok())
    return Status(channels.status().code(), path + ": " + channels.status().message());

  const std::filesystem::path target(path);
  const std::filesystem::path folder = target.parent_path().empty() ? "." : target.parent_path();
  TemporaryFile file(
      (folder / ("." + target.filename().string() + ".part-" + std::to_string(::getpid())))
          .string());
  if (!file.is_open()) return failed();
  if (is_pfm) {
    if (!write_pfm(image, file)) return failed();
  } else {
    TESSERA_RETURN_IF_ERROR(write_by_plugin(image, path, *channels, *plugin, options, file));
  }
  if (!file.sync_and_close() || !file.rename_to(path)) return failed();
  if (const int directory = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      directory >= 0) {
    ::fsync(directory);  // a file system that cannot sync the name is no failure
    ::close(directory);
  }
  return Status::ok();
}

}  // namespace tessera::master
