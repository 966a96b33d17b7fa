// SPDX-License-Identifier: Apache-2.0
#include "master/image/picture_budget.h"

namespace tessera::master {

// Requires: sides of at most 16384 pixels and files of at most 1 GiB, so that no sum overflows.
Status PictureBudget::book(std::uint64_t file_bytes, std::uint64_t texels,
                           std::uint64_t decoded_bytes) {
  if (texels_ + texels > kTexelsMax)
    return Status::resource_exhausted("is one too many: the scene's pictures have more than " +
                                      std::to_string(kTexelsMax) +
                                      " pixels together; make them smaller");
  const std::uint64_t files = file_bytes_ + file_bytes, decoded = decoded_bytes_ + decoded_bytes;
  if (decoded > kDecodedBytesFree + kDecodedRatioMax * files)
    return Status::resource_exhausted("would decode to " + std::to_string(decoded_bytes >> 20) +
                                      " MiB from " + std::to_string(file_bytes >> 10) +
                                      " KiB, which with the scene's other pictures is more than " +
                                      std::to_string(kDecodedRatioMax) +
                                      " times their files; make it smaller");
  file_bytes_ = files;
  texels_ += texels;
  decoded_bytes_ = decoded;
  return {};
}

}  // namespace tessera::master
