// SPDX-License-Identifier: Apache-2.0
// Pictures of a sequence that failed, so that the others go on: each is tried once more when these
// are done, unless that is known to be in vain, and what is left is told at the end.
//
// Threads. One owner.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/frame/frame_settings.h"

namespace tessera::master {

class FailedPictures {
 public:
  struct Picture {
    Status why;
    FrameSettings settings;  // of its first pass
  };

  // One of the picture's passes failed. Only the first failure is kept.
  void add(long number, Status why, const FrameSettings& settings) {
    pictures_.try_emplace(number, Picture{std::move(why), settings});
  }
  void mended(long number) { pictures_.erase(number); }
  bool contains(long number) const { return pictures_.contains(number); }
  const std::map<long, Picture>& pictures() const { return pictures_; }
  bool is_empty() const { return pictures_.empty(); }

  // Whether trying the picture again may help.
  static bool is_worth_a_try(const Picture& picture) {
    return picture.why.code() == StatusCode::kUnavailable;
  }

  // Lines for a person: how many of `total` are missing, and which ones and why, those that follow
  // one another with one reason together.
  std::string text(long total) const {
    std::vector<std::string> groups;
    for (auto picture = pictures_.begin(); picture != pictures_.end();) {
      const long first = picture->first;
      const std::string& why = picture->second.why.message();
      long last = first;
      while (++picture != pictures_.end() && picture->first == last + 1 &&
             picture->second.why.message() == why) {
        ++last;
      }
      groups.push_back((first == last
                            ? "frame " + std::to_string(first)
                            : "frames " + std::to_string(first) + " to " + std::to_string(last)) +
                       ": " + why);
    }
    std::string lines = std::to_string(pictures_.size()) + " of " + std::to_string(total) +
                        (total == 1 ? " frame" : " frames") + " failed";
    if (groups.size() == 1) return lines + "; " + groups[0];
    for (std::size_t i = 0; i < groups.size() && i < kLinesMax; ++i) lines += "\n  " + groups[i];
    if (groups.size() > kLinesMax)
      lines += "\n  and " + std::to_string(groups.size() - kLinesMax) + " more lines like these";
    return lines;
  }

 private:
  static constexpr std::size_t kLinesMax = 100;
  std::map<long, Picture> pictures_;
};

}  // namespace tessera::master
