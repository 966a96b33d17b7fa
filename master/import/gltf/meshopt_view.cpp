// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/meshopt_view.h"

#include <meshoptimizer.h>

namespace tessera::import {
namespace {

// The codec packs 16 equal bytes into two bits at best, 64 : 1, behind a head of at most one
// vertex. A view that asks for more than twice that ratio is after memory, not after its bytes.
constexpr std::uint64_t kPackedRatioMax = 128, kPackedHeadBytes = 64 * 1024;

Status filtered(const GltfObject& packed, const std::string& filter, std::string& bytes,
                std::size_t count, std::size_t stride) {
  if (filter.empty() || filter == "NONE") return Status::ok();
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
    meshopt_decodeFilterOct(bytes.data(), count, stride);
  } else if (filter == "QUATERNION" && stride == 8) {
    meshopt_decodeFilterQuat(bytes.data(), count, stride);
  } else if (filter == "EXPONENTIAL" && stride % 4 == 0) {
    meshopt_decodeFilterExp(bytes.data(), count, stride);
  } else {
    return packed.refuse("filter", "is '" + printable(filter) + "', which a byteStride of " +
                                       std::to_string(stride) + " does not have");
  }
  return Status::ok();
}

}  // namespace

Result<std::string> unpack_meshopt_view(const GltfObject& packed,
                                        std::span<const std::byte> bytes) {
  packed.check_keys({"buffer", "byteOffset", "byteLength", "byteStride", "count", "mode", "filter"},
                    {});
  const auto stride = packed.refused_whole("byteStride", 0, 1, 256);
  if (!stride.is_ok()) return stride.status();
  const std::uint64_t unpacked_bytes_max = kPackedRatioMax * bytes.size() + kPackedHeadBytes;
  const auto count = packed.refused_whole("count", 0, 1, unpacked_bytes_max / *stride);
  if (!count.is_ok()) return count.status();
  const std::string mode = packed.text("mode"), filter = packed.text("filter");
  const auto* const from = reinterpret_cast<const unsigned char*>(bytes.data());
  const bool is_index = mode == "TRIANGLES" || mode == "INDICES";
  if (!is_index && mode != "ATTRIBUTES")
    return packed.refuse(
        "mode", "is '" + printable(mode) + "'; it must be ATTRIBUTES, TRIANGLES or INDICES");
  if (is_index ? *stride != 2 && *stride != 4 : *stride % 4 != 0)
    return packed.refuse("byteStride",
                         "is " + std::to_string(*stride) + ", which " + mode + " cannot have");
  if (mode == "TRIANGLES" && *count % 3 != 0)
    return packed.refuse("count", "is " + std::to_string(*count) + ", which is no triangles");
  std::string unpacked(*count * *stride, '\0');
  const int error =
      mode == "ATTRIBUTES"
          ? meshopt_decodeVertexBuffer(unpacked.data(), *count, *stride, from, bytes.size())
      : mode == "TRIANGLES"
          ? meshopt_decodeIndexBuffer(unpacked.data(), *count, *stride, from, bytes.size())
          : meshopt_decodeIndexSequence(unpacked.data(), *count, *stride, from, bytes.size());
  if (error != 0) return packed.refuse("mode", mode + ": the packed bytes are damaged");
  if (!is_index) TESSERA_RETURN_IF_ERROR(filtered(packed, filter, unpacked, *count, *stride));
  return unpacked;
}

}  // namespace tessera::import
