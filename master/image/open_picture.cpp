// SPDX-License-Identifier: Apache-2.0
#include "master/image/open_picture.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace tessera::master {
namespace {

constexpr std::size_t kErrorBytes = 512;

// Messages of libraries end in line breaks, or have them inside.
std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

Result<OpenPicture> OpenPicture::open_file(const std::string& path) {
  const auto file = picture_format_of(path);
  if (!file.is_ok()) return file.status();
  auto opened = open(path, file->format->reader, {});
  if (opened.is_ok()) opened->file_bytes_ = file->file_bytes;
  return opened;
}

Result<OpenPicture> OpenPicture::open_bytes(const char* reader, std::span<const std::byte> bytes) {
  auto opened = open("", reader, bytes);
  if (opened.is_ok()) opened->file_bytes_ = bytes.size();
  return opened;
}

Result<OpenPicture> OpenPicture::open(const std::string& path, const char* reader,
                                      std::span<const std::byte> bytes) {
  const auto plugin = image_plugin();
  if (!plugin.is_ok()) return plugin.status();
  OpenPicture opened(*plugin);
  char error[kErrorBytes] = {};
  opened.picture_.reset(plugin->open_picture(path.c_str(), reader, bytes.data(), bytes.size(),
                                             &opened.shape_, error, sizeof(error)));
  if (opened.picture_ == nullptr) return Status::data_loss("cannot be read: " + one_line(error));
  return opened;
}

Status OpenPicture::read_as(PluginTexels type, int channels, int stride, void* texels) const {
  char error[kErrorBytes] = {};
  if (plugin_.read_picture(picture_.get(), type, channels, stride, texels, error, sizeof(error)) !=
      0)
    return Status::data_loss("is damaged: " + one_line(error));
  return {};
}

bool OpenPicture::make_linear(std::span<float> values) const {
  return plugin_.make_linear(picture_.get(), values.data(), values.size()) != 0;
}

std::vector<std::string> OpenPicture::attributes() const {
  const std::unique_ptr<char, decltype(&std::free)> texts(plugin_.attributes(picture_.get()),
                                                          &std::free);
  std::vector<std::string> all;
  for (const char* text = texts.get(); text != nullptr && *text != '\0';
       text += std::strlen(text) + 1)
    all.emplace_back(text);
  return all;
}

}  // namespace tessera::master
