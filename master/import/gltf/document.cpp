// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/document.h"

#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/scene_io/text_scanner.h"
#include "master/import/gltf/meshopt_view.h"
#include "master/import/gltf/uri.h"

namespace tessera::import {
namespace {

using nlohmann::json;

// Most bytes of a file or buffer; the importer's limit on memory is the tighter bound.
constexpr std::uint64_t kFileBytesMax = std::uint64_t{4} << 30;
constexpr std::size_t kGlbHeaderBytes = 12, kChunkHeaderBytes = 8;
constexpr std::uint32_t kChunkJson = 0x4e4f534a, kChunkBinary = 0x004e4942;

std::uint32_t u32_at(std::string_view bytes, std::size_t offset) {
  std::uint32_t value = 0;  // file and machine are little-endian
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

ByteSpan span_of(std::string_view bytes) {
  return {reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()};
}

// The library's message without its number: "parse error at line 3, column 7: ...".
std::string reason(const std::exception& error) {
  std::string text = error.what();
  if (const auto end = text.find("] "); end != std::string::npos) text = text.substr(end + 2);
  constexpr std::size_t kShownMax = 200;
  return text.size() > kShownMax ? text.substr(0, kShownMax) + "..." : text;
}

}  // namespace

struct GltfDocument::Json {
  json value;
};

std::string singular(std::string_view array) {
  if (array == "meshes") return "mesh";
  return std::string(array.substr(0, array.size() - 1));
}

GltfDocument::GltfDocument(std::string path, WarningGroup& warnings)
    : path_(std::move(path)),
      folder_(std::filesystem::path(path_).parent_path().string()),
      warnings_(warnings),
      json_(std::make_unique<Json>()) {}

GltfDocument::~GltfDocument() = default;

Result<std::unique_ptr<GltfDocument>> GltfDocument::open(const std::string& path,
                                                         WarningGroup& warnings) {
  auto bytes = read_whole_file(path, kFileBytesMax);
  if (!bytes.is_ok()) return bytes.status();
  std::unique_ptr<GltfDocument> document(new GltfDocument(path, warnings));
  document->file_ = std::move(*bytes);
  TESSERA_RETURN_IF_ERROR(document->parse());
  TESSERA_RETURN_IF_ERROR(document->check_asset());
  document->buffers_.resize(document->count("buffers"));
  document->views_.resize(document->count("bufferViews"));
  return document;
}

Status GltfDocument::parse() {
  std::string_view text = file_;
  if (text.starts_with("glTF")) {
    auto chunk = split_glb();
    if (!chunk.is_ok()) return chunk.status();
    text = *chunk;
  }
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || text[first] != '{')
    return Status::invalid_argument("is no glTF file: neither JSON nor binary glTF");
  try {
    json_->value = json::parse(text.begin(), text.end());
  } catch (const json::exception& error) {
    return Status::invalid_argument("is no JSON: " + reason(error));
  }
  root_ = GltfObject(&json_->value, "the file", &warnings_);
  return Status::ok();
}

// Splits a binary file (glTF 2.0, section 4): a header, the JSON chunk, and at most one chunk with
// bytes. Other chunks are passed over. Returns: the JSON.
Result<std::string_view> GltfDocument::split_glb() {
  const std::string_view file = file_;
  if (file.size() < kGlbHeaderBytes + kChunkHeaderBytes)
    return Status::invalid_argument("is a binary glTF file cut short");
  if (const std::uint32_t version = u32_at(file, 4); version != 2)
    return Status::invalid_argument("is binary glTF of version " + std::to_string(version) +
                                    "; it must be 2");
  const std::size_t end = u32_at(file, 8);
  if (end > file.size())
    return Status::invalid_argument("holds " + std::to_string(file.size()) + " bytes of the " +
                                    std::to_string(end) + " that its header says");
  std::optional<std::string_view> text;
  for (std::size_t at = kGlbHeaderBytes; at + kChunkHeaderBytes <= end;) {
    const std::size_t size = u32_at(file, at);
    const std::uint32_t kind = u32_at(file, at + 4);
    at += kChunkHeaderBytes;
    if (size > end - at)
      return Status::invalid_argument("has a chunk of " + std::to_string(size) +
                                      " bytes beyond its end");
    if (!text) {
      if (kind != kChunkJson) return Status::invalid_argument("does not begin with a JSON chunk");
      text = file.substr(at, size);
    } else if (kind == kChunkBinary && !binary_chunk_) {
      binary_chunk_ = span_of(file.substr(at, size));
    }
    at += size;
  }
  if (!text) return Status::invalid_argument("has no JSON chunk");
  return *text;
}

Status GltfDocument::check_asset() {
  const GltfObject asset(json_->value.contains("asset") ? &json_->value["asset"] : nullptr, "asset",
                         &warnings_);
  const std::string version = asset.text("version");
  if (!version.starts_with("2.")) {
    return Status::invalid_argument(
        "asset.version is '" + printable(version) +
        "'; only glTF 2 is read: convert the file with a program that made it or knows it");
  }
  const std::string least = asset.text("minVersion");
  if (!least.empty() && least != "2.0")
    return Status::invalid_argument("asset.minVersion is '" + printable(least) + "'; 2.0 is read");
  asset.check_keys({"version", "minVersion", "generator", "copyright"}, {"KHR_xmp_json_ld"});
  return Status::ok();
}

std::size_t GltfDocument::count(std::string_view array) const {
  const auto member = json_->value.find(std::string(array));
  return member != json_->value.end() && member->is_array() ? member->size() : 0;
}

GltfObject GltfDocument::at(std::string_view array, std::size_t index) const {
  const std::string name = singular(array) + " " + std::to_string(index);
  return GltfObject(&json_->value[std::string(array)][index], name, &warnings_).named(name);
}

Result<ByteSpan> GltfDocument::buffer(std::size_t index) {
  if (!buffers_[index]) {
    auto bytes = read_buffer(index);
    if (!bytes.is_ok()) return bytes.status();
    buffers_[index] = *bytes;
  }
  return *buffers_[index];
}

Result<ByteSpan> GltfDocument::read_buffer(std::size_t index) {
  const GltfObject source = at("buffers", index);
  source.check_keys({"uri", "byteLength"}, {"EXT_meshopt_compression"});
  if (!source.has("byteLength")) return source.refuse("byteLength", "is missing");
  const auto size = source.refused_whole("byteLength", 0, 1, kFileBytesMax);
  if (!size.is_ok()) return size.status();
  ByteSpan bytes;
  if (source.has("uri")) {
    auto read = read_uri(folder_, source.text("uri"), kFileBytesMax);
    if (!read.is_ok()) return source.refuse("uri", read.status().message());
    owned_.push_back(std::make_unique<std::string>(std::move(*read)));
    bytes = span_of(*owned_.back());
  } else if (index == 0 && binary_chunk_) {
    bytes = *binary_chunk_;
  } else {
    return source.refuse("uri", "is missing, and there is no binary chunk that it could be");
  }
  if (bytes.size() < *size) {
    return source.refuse("byteLength", "is " + std::to_string(*size) + ", but there are " +
                                           std::to_string(bytes.size()) + " bytes");
  }
  return bytes.first(*size);
}

Result<ByteSpan> GltfDocument::view(std::size_t index) {
  if (!views_[index]) {
    auto bytes = read_view(index);
    if (!bytes.is_ok()) return bytes.status();
    views_[index] = *bytes;
  }
  return *views_[index];
}

Result<ByteSpan> GltfDocument::read_view(std::size_t index) {
  const GltfObject source = at("bufferViews", index);
  source.check_keys({"buffer", "byteOffset", "byteLength", "byteStride", "target"},
                    {"EXT_meshopt_compression"});
  const GltfObject packed = source.extension("EXT_meshopt_compression");
  const GltfObject& place = packed.is_there() ? packed : source;
  const auto number = place.refused_index("buffer", count("buffers"));
  if (!number.is_ok()) return number.status();
  if (!*number) return place.refuse("buffer", "is missing");
  const auto offset = place.refused_whole("byteOffset", 0, 0, kFileBytesMax);
  if (!offset.is_ok()) return offset.status();
  const auto size = place.refused_whole("byteLength", 0, 0, kFileBytesMax);
  if (!size.is_ok()) return size.status();
  const auto bytes = buffer(**number);
  if (!bytes.is_ok()) return bytes.status();
  if (*offset > bytes->size() || *size > bytes->size() - *offset) {
    return place.refuse("byteLength", "ends " + std::to_string(*offset + *size - bytes->size()) +
                                          " bytes behind buffer " + std::to_string(**number));
  }
  const ByteSpan part = bytes->subspan(*offset, *size);
  if (!packed.is_there()) return part;
  auto unpacked = unpack_meshopt_view(packed, part);
  if (!unpacked.is_ok()) return unpacked.status();
  owned_.push_back(std::make_unique<std::string>(std::move(*unpacked)));
  return span_of(*owned_.back());
}

}  // namespace tessera::import
