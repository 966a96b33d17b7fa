// SPDX-License-Identifier: Apache-2.0
#include "master/image/image_read.h"

#include "common/base/limits.h"
#include "master/image/open_picture.h"
#include "master/image/picture_budget.h"

namespace tessera::master {
namespace {

Result<FloatImage> read(const std::string& path) {
  const auto picture = OpenPicture::open_file(path);
  if (!picture.is_ok()) return picture.status();
  const PluginShape& shape = picture->shape();
  if (shape.width < 1 || shape.height < 1 || shape.width > kImageSideMaxPx ||
      shape.height > kImageSideMaxPx || shape.depth > 1)
    return Status::resource_exhausted("its sides must be 1 to " + std::to_string(kImageSideMaxPx) +
                                      " pixels");
  if (shape.channels < 1) return Status::data_loss("has no channels");
  FloatImage image;
  image.width_px = shape.width;
  image.height_px = shape.height;
  const auto count = static_cast<std::size_t>(shape.width) * static_cast<std::size_t>(shape.height);
  PictureBudget budget;
  TESSERA_RETURN_IF_ERROR(budget.book(picture->file_bytes(), count, 3 * sizeof(float) * count));
  image.rgb.resize(3 * count);
  const bool is_grey = shape.channels < 3;
  TESSERA_RETURN_IF_ERROR(picture->read(is_grey ? 1 : 3, 3, std::span(image.rgb)));
  if (is_grey) {
    for (std::size_t i = 0; i < image.rgb.size(); i += 3)
      image.rgb[i + 1] = image.rgb[i + 2] = image.rgb[i];
  }
  image.is_display = picture->make_linear(image.rgb);
  for (const std::string& text : picture->attributes()) {
    if (const auto equals = text.find('='); equals != std::string::npos)
      image.attributes.emplace(text.substr(0, equals), text.substr(equals + 1));
  }
  return image;
}

}  // namespace

Result<FloatImage> read_image(const std::string& path) {
  auto image = read(path);
  if (image.is_ok()) return image;
  return Status(image.status().code(), path + ": " + image.status().message());
}

}  // namespace tessera::master
