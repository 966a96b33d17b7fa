// SPDX-License-Identifier: Apache-2.0
#include "master/image/picture_format.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <memory>

#include "common/base/path_suffix.h"

namespace tessera::master {
namespace {

bool is_webp(std::string_view head) {
  return head.starts_with("RIFF") &&
         head.substr(std::min<std::size_t>(head.size(), 8)).starts_with("WEBP");
}
bool is_tiff(std::string_view head) {
  return head.starts_with(std::string_view("II*\0", 4)) ||
         head.starts_with(std::string_view("MM\0*", 4));
}
bool is_hdr(std::string_view head) {
  return head.starts_with("#?RADIANCE") || head.starts_with("#?RGBE");
}
bool is_pfm(std::string_view head) { return head.starts_with("PF\n") || head.starts_with("Pf\n"); }

// A TGA file has no sign of its own; its header (Truevision, "TGA file format specification", 1991)
// says a kind, sizes and depths of which few are possible.
bool is_targa(std::string_view head) {
  if (head.size() < 18) return false;
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(head[i]); };
  const int map = at(1), kind = at(2), bits = at(16);
  const bool is_kind = (kind >= 1 && kind <= 3) || (kind >= 9 && kind <= 11);
  const bool is_mapped = kind == 1 || kind == 9;
  const bool has_depth = bits == 8 || bits == 15 || bits == 16 || bits == 24 || bits == 32;
  return is_kind && map <= 1 && (!is_mapped || map == 1) && has_depth && (at(12) | at(13)) != 0 &&
         (at(14) | at(15)) != 0;
}

// Surer signs stand before vaguer ones.
constexpr PictureFormat kFormats[] = {
    {"png", "a PNG picture", ".png", "\x89PNG\r\n\x1a\n"},
    {"jpeg", "a JPEG picture", ".jpg,.jpeg", "\xff\xd8\xff"},
    {"webp", "a WebP picture", ".webp", "", is_webp},
    {"openexr", "an OpenEXR picture", ".exr", "\x76\x2f\x31\x01"},
    {"hdr", "a Radiance picture", ".hdr", "", is_hdr},
    {"tiff", "a TIFF picture", ".tif,.tiff", "", is_tiff},
    {"pnm", "a PFM picture", ".pfm", "", is_pfm},
    {"bmp", "a BMP picture", ".bmp", "BM"},
    {"targa", "a TGA picture", ".tga", "", is_targa},
};

bool has_suffix(const PictureFormat& format, const std::string& suffix) {
  return !suffix.empty() &&
         ("," + std::string(format.suffixes) + ",").find("," + suffix + ",") != std::string::npos;
}

std::string known_suffixes() {
  std::string list;
  for (const PictureFormat& format : kFormats) {
    for (const char c : format.suffixes) list += c == ',' ? std::string(" ") : std::string(1, c);
    list += ' ';
  }
  list.pop_back();
  return list;
}

}  // namespace

const PictureFormat* picture_format_of_head(std::string_view head) {
  const auto* const found =
      std::ranges::find_if(kFormats, [&](const PictureFormat& f) { return f.matches(head); });
  return found == std::end(kFormats) ? nullptr : found;
}

Result<PictureFile> picture_format_of(const std::string& path) {
  const std::string suffix = suffix_of(path);
  const auto* const named =
      std::ranges::find_if(kFormats, [&](const PictureFormat& f) { return has_suffix(f, suffix); });
  if (named == std::end(kFormats))
    return Status::invalid_argument("is no picture by its suffix; read are " + known_suffixes());
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"),
                                                             &std::fclose);
  struct stat info {};
  if (!file || fstat(fileno(file.get()), &info) != 0)
    return Status::not_found(std::string("cannot be opened: ") + std::strerror(errno));
  if (!S_ISREG(info.st_mode)) return Status::invalid_argument("is not a regular file");
  const auto bytes = static_cast<std::uint64_t>(info.st_size);
  if (bytes > kPictureFileBytesMax)
    return Status::resource_exhausted("is larger than " +
                                      std::to_string(kPictureFileBytesMax >> 20) + " MiB");
  char head[kPictureHeadBytes];
  const std::string_view seen(head, std::fread(head, 1, sizeof(head), file.get()));
  if (named->matches(seen)) return PictureFile{named, bytes};
  if (const PictureFormat* const found = picture_format_of_head(seen)) {
    return Status::invalid_argument(
        "is " + std::string(found->name) + " by its content; rename it to end in " +
        std::string(found->suffixes.substr(0, found->suffixes.find(','))));
  }
  return Status::data_loss("does not begin as " + std::string(named->name) + " does");
}

}  // namespace tessera::master
