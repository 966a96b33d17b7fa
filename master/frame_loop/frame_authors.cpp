// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/frame_authors.h"

#include <algorithm>
#include <vector>

namespace tessera::master {

void FrameAuthors::slave_joined(SessionId session, const std::string& name) {
  authors_[session].name = name;
  sessions_.push_back(session);
  if (sessions_.size() <= kSessionsMax) return;
  authors_.erase(sessions_.front());  // numbers of sessions are random
  sessions_.pop_front();
}

void FrameAuthors::add(SessionId session, FrameId frame) {
  const auto author = authors_.find(session);
  if (author == authors_.end()) return;
  std::deque<Range>& frames = author->second.frames;
  if (!frames.empty() && frame <= frames.back().last) return;
  if (!frames.empty() && frame == frames.back().last + 1) {
    frames.back().last = frame;
    return;
  }
  frames.push_back({frame, frame});
  if (frames.size() <= kRangesMax) return;
  frames.pop_front();
  author->second.is_cut = true;
}

bool FrameAuthors::is_of(SessionId session, const std::string& name) const {
  const auto author = authors_.find(session);
  return author != authors_.end() && author->second.name == name;
}

std::string FrameAuthors::frames_of(const std::string& name) const {
  std::vector<Range> ranges;
  bool is_cut = false;
  for (const auto& [other, author] : authors_) {
    if (author.name != name) continue;
    ranges.insert(ranges.end(), author.frames.begin(), author.frames.end());
    is_cut = is_cut || author.is_cut;
  }
  std::sort(ranges.begin(), ranges.end(),
            [](const Range& a, const Range& b) { return a.first < b.first; });
  std::vector<Range> joined;
  for (const Range& range : ranges) {
    if (!joined.empty() && range.first <= joined.back().last + 1) {
      joined.back().last = std::max(joined.back().last, range.last);
    } else {
      joined.push_back(range);
    }
  }
  const std::size_t first = joined.size() - std::min(joined.size(), kRangesTold);
  std::string text = is_cut || first > 0 ? "earlier ones" : "";
  for (std::size_t i = first; i < joined.size(); ++i) {
    if (!text.empty()) text += ", ";
    text += std::to_string(joined[i].first);
    if (joined[i].last > joined[i].first) text += "-" + std::to_string(joined[i].last);
  }
  return text;
}

}  // namespace tessera::master
