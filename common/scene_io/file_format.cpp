// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/file_format.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <memory>
#include <vector>

#include "common/base/path_suffix.h"
#include "common/scene_io/text_scanner.h"

namespace tessera {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

std::string_view text_of(std::string_view head) {
  if (head.starts_with(kByteOrderMark)) head.remove_prefix(kByteOrderMark.size());
  return head.substr(std::min(head.find_first_not_of(kSpace), head.size()));
}
bool is_text(std::string_view head) { return head.find('\0') == head.npos; }

bool is_gltf(std::string_view head, std::uint64_t) { return text_of(head).starts_with('{'); }
bool is_hdr(std::string_view head, std::uint64_t) {
  return head.starts_with("#?RADIANCE") || head.starts_with("#?RGBE");
}
bool is_ply(std::string_view head, std::uint64_t) {
  return head.starts_with("ply\n") || head.starts_with("ply\r");
}

// A binary STL file has 80 bytes of anything, a count and 50 bytes for each triangle; a text one
// has facets.
bool is_stl(std::string_view head, std::uint64_t file_bytes) {
  if (head.size() >= 84) {
    std::uint32_t count = 0;
    for (std::size_t i = 4; i-- > 0;) count = count << 8 | static_cast<unsigned char>(head[80 + i]);
    if (file_bytes == 84 + std::uint64_t{50} * count) return true;
  }
  const std::string_view text = text_of(head);
  if (!text.starts_with("solid") && !text.starts_with("SOLID")) return false;
  // Binary files that begin with this word count, too: the reader says what is wrong with their
  // size.
  return !is_text(head) || text.find("facet") != text.npos || text.find("FACET") != text.npos ||
         text.find("endsolid") != text.npos;
}

bool is_fbx(std::string_view head, std::uint64_t) {
  if (head.starts_with(std::string_view("Kaydara FBX Binary  \0", 21))) return true;
  const std::string_view text = text_of(head);
  return is_text(head) && (text.starts_with("FBXHeaderExtension") ||
                           (text.starts_with(';') && text.find("FBXHeaderExtension") != text.npos));
}

// The first line is one of the start section: an S and its number in the columns 73 to 80.
bool is_iges(std::string_view head, std::uint64_t) {
  return head.size() >= 80 && head[72] == 'S' && head.substr(0, 80).find('\n') == head.npos &&
         (head.substr(73, 7) == "      1" || head.substr(73, 7) == "0000001");
}

bool is_collada(std::string_view head, std::uint64_t) {
  const std::string_view text = text_of(head);
  return is_text(head) && text.starts_with('<') && text.find("<COLLADA") != text.npos;
}

// Files of patches begin with a line that is their number, and nothing else.
bool is_bpt(std::string_view head, std::uint64_t) {
  if (!is_text(head)) return false;
  TextScanner scanner(head);
  while (scanner.next_line()) {
    TextScanner words(scanner.line().substr(0, scanner.line().find('#')));
    if (!words.next_line()) continue;
    const std::string_view word = words.word();
    if (word.empty()) continue;
    return TextScanner::number_of<std::int64_t>(word).has_value() && words.word().empty();
  }
  return false;
}

// An OBJ file is text of which at least one line begins with a word of the format. A beginning of
// nothing but comments is enough, too, where the file goes on behind it.
bool is_obj(std::string_view head, std::uint64_t file_bytes) {
  static constexpr std::array<std::string_view, 19> kWords = {
      "v", "vt",     "vn",     "vp",     "f",      "fo",     "o",   "g",    "s",   "l",
      "p", "usemtl", "mtllib", "usemap", "maplib", "cstype", "deg", "surf", "curv"};
  if (!is_text(head)) return false;
  TextScanner scanner(head);
  bool is_all_comment = true;
  while (scanner.next_line()) {
    const std::string_view word = scanner.word();
    if (word.empty() || word.front() == '#') continue;
    is_all_comment = false;
    if (std::find(kWords.begin(), kWords.end(), word) != kWords.end()) return true;
  }
  return is_all_comment && !head.empty() && file_bytes > head.size();
}

enum Kind { kScene, kSky };

#define TESSERA_FORMAT(enumerator, suffix, name, kind, place, begins, look, reader) \
  FormatEntry{FileFormat::enumerator, suffix, name, (kind) == kSky, place, begins, look},
constexpr FormatEntry kFormats[] = {
#include "common/scene_io/file_formats.inc"
};

// Names a format that is often given by mistake; empty for others.
std::string_view foreign_name(std::string_view head) {
  static constexpr std::pair<std::string_view, std::string_view> kForeign[] = {
      {"\x89PNG", "a PNG picture"},
      {"\xff\xd8\xff", "a JPEG picture"},
      {"BLENDER", "a Blender file; export it as .glb"},
      {"PK\x03\x04", "a ZIP archive; unpack it"},
      {"\x1f\x8b", "packed by gzip; unpack it"},
      {"#usda", "a USD file, which is not read; export it as .glb"},
      {"PXR-USDC", "a USD file, which is not read; export it as .glb"},
      {"MM\x00", "a 3DS file, which is not read; export it as .glb"},
      {"<!DOCTYPE", "a web page: the download has failed"},
      {"<html", "a web page: the download has failed"},
      {"version https://git-lfs", "a pointer of Git LFS: fetch the file itself"}};
  for (const auto& [begin, name] : kForeign) {
    if (head.starts_with(begin)) return name;
  }
  return {};
}

}  // namespace

std::span<const FormatEntry> file_formats() { return kFormats; }

const FormatEntry* format_of_suffix(const std::string& path) {
  const std::string suffix = suffix_of(path);
  const auto* const known = std::ranges::find(kFormats, suffix, &FormatEntry::suffix);
  return known == std::end(kFormats) ? nullptr : known;
}

const FormatEntry* format_of_content(std::string_view head, std::uint64_t file_bytes) {
  const auto* const known = std::ranges::find_if(
      kFormats, [&](const FormatEntry& e) { return e.matches(head, file_bytes); });
  return known == std::end(kFormats) ? nullptr : known;
}

std::string suffix_list(bool is_sky) {
  std::vector<FormatEntry> told(std::begin(kFormats), std::end(kFormats));
  std::erase_if(told, [&](const FormatEntry& entry) { return entry.is_sky != is_sky; });
  std::ranges::stable_sort(told, {}, &FormatEntry::place);
  std::string list;
  for (const FormatEntry& entry : told) list.append(list.empty() ? "" : ", ").append(entry.suffix);
  return list;
}

Result<FileFormat> check_content(const std::string& path) {
  const FormatEntry* const named = format_of_suffix(path);
  if (named == nullptr) {
    return Status::invalid_argument(path + ": unknown suffix '" + suffix_of(path) +
                                    "'; known are " + suffix_list(false) + ", and " +
                                    suffix_list(true) + " for a sky");
  }
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"),
                                                             &std::fclose);
  if (!file) return Status::not_found(path + ": " + std::strerror(errno));
  std::string head(kHeadBytes, '\0');
  head.resize(std::fread(head.data(), 1, head.size(), file.get()));
  const long bytes = std::fseek(file.get(), 0, SEEK_END) == 0 ? std::ftell(file.get()) : -1;
  const std::uint64_t file_bytes = bytes < 0 ? head.size() : static_cast<std::uint64_t>(bytes);
  if (named->matches(head, file_bytes)) return named->format;
  if (const FormatEntry* found = format_of_content(head, file_bytes)) {
    return Status::invalid_argument(
        path + " is " + std::string(found->name) + " by its content; rename it to '" +
        path.substr(0, path.size() - named->suffix.size()) + std::string(found->suffix) + "'");
  }
  if (const std::string_view foreign = foreign_name(head); !foreign.empty())
    return Status::invalid_argument(path + " is " + std::string(foreign));
  return Status::invalid_argument(path + ": does not begin as " + std::string(named->name) +
                                  " does; the file is damaged or something else");
}

}  // namespace tessera
