// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iterator>

#include "common/base/path_suffix.h"
#include "master/image/image_file.h"

namespace tessera::master {
namespace {

Status check_folder(const std::string& text) {
  const std::filesystem::path parent = std::filesystem::path(text).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  struct stat info {};
  if (stat(folder.c_str(), &info) != 0 || !S_ISDIR(info.st_mode)) {
    return Status::not_found("output folder " + folder + " does not exist; make it first");
  }
  if (access(folder.c_str(), W_OK) != 0) {
    return Status::permission_denied("cannot write into folder " + folder + ": " +
                                     std::strerror(errno));
  }
  if (stat(text.c_str(), &info) == 0 && !S_ISREG(info.st_mode)) {
    return Status::invalid_argument("output " + text + " is not a regular file");
  }
  return Status::ok();
}

}  // namespace

Result<OutputPattern> OutputPattern::parse(const std::string& text, bool has_several_frames) {
  const std::string suffix = suffix_of(text);
  static constexpr const char* kKnown[] = {".exr", ".png", ".jpg", ".jpeg", ".hdr", ".pfm"};
  if (std::find(std::begin(kKnown), std::end(kKnown), suffix) == std::end(kKnown)) {
    return Status::invalid_argument("output " + text + ": unknown suffix '" + suffix +
                                    "'; give .exr, .png, .jpg, .hdr or .pfm");
  }
  OutputPattern pattern;
  pattern.prefix_ = text;
  if (const auto percent = text.find('%'); percent != std::string::npos) {
    const bool is_number = text.size() > percent + 3 && text[percent + 1] == '0' &&
                           text[percent + 2] >= '1' && text[percent + 2] <= '9' &&
                           text[percent + 3] == 'd';
    if (!is_number || text.find('%', percent + 1) != std::string::npos) {
      return Status::invalid_argument("output " + text +
                                      ": the only % allowed is one frame number with leading "
                                      "zeros, %01d to %09d, such as %04d");
    }
    pattern.digits_ = text[percent + 2] - '0';
    pattern.prefix_ = text.substr(0, percent);
    pattern.suffix_ = text.substr(percent + 4);
  } else if (has_several_frames) {
    return Status::invalid_argument(
        "output " + text + ": several frames need a number in the name, such as frame-%04d" +
        suffix);
  }
  TESSERA_RETURN_IF_ERROR(check_folder(text));
  return pattern;
}

std::string OutputPattern::path(long frame_number) const {
  if (digits_ == 0) return prefix_;
  char number[32];
  std::snprintf(number, sizeof(number), "%0*ld", digits_, frame_number);
  return prefix_ + number + suffix_;
}

}  // namespace tessera::master
