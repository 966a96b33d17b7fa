// SPDX-License-Identifier: Apache-2.0
#include "master/commands/animation_choice.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <utility>
#include <vector>

#include "common/scene/animation.h"
#include "common/scene/pose.h"

namespace tessera::master {
namespace {

// A list that a person can read: "'a', 'b' and 17 more".
std::string listed(const std::vector<std::string>& names, std::uint32_t but) {
  constexpr std::size_t kShownMax = 12;
  std::string text;
  std::size_t shown = 0, more = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i == but) continue;
    if (shown == kShownMax) {
      ++more;
      continue;
    }
    text += (shown++ > 0 ? ", '" : "'") + names[i] + "'";
  }
  if (more > 0) text += " and " + std::to_string(more) + " more";
  return text;
}

// The clip of a name, else of a number from 1. Returns: names.size() when there is none.
std::uint32_t clip_of(const std::vector<std::string>& names, const std::string& asked) {
  const auto named = std::find(names.begin(), names.end(), asked);
  if (named != names.end()) return static_cast<std::uint32_t>(named - names.begin());
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(asked.data(), asked.data() + asked.size(), number);
  const bool is_number = error == std::errc() && end == asked.data() + asked.size();
  return is_number && number >= 1 && number <= names.size()
             ? number - 1
             : static_cast<std::uint32_t>(names.size());
}

}  // namespace

Result<std::string> choose_animation(Scene& scene, const std::string& asked) {
  if (!scene.animation) {
    if (asked.empty() || asked == "none") return std::string();
    return Status::invalid_argument("--animation " + asked + ": the scene holds no animation");
  }
  const std::vector<std::string> names = scene.animation->clip_names();
  if (asked == "none") {
    SceneAnimation rest = *scene.animation;
    rest.clips.clear();
    rest.names.clear();
    rest.channels.clear();
    rest.key_seconds.clear();
    rest.key_values.clear();
    scene.animation = std::make_shared<const SceneAnimation>(std::move(rest));
    Result<Scene> posed = ScenePoser().at(scene, 0);
    if (!posed.is_ok()) return posed.status();
    scene = *std::move(posed);
    scene.animation = nullptr;
    return std::string("the rest pose is shown");
  }
  const std::uint32_t clip = asked == "all" ? kNoIndex : asked.empty() ? 0 : clip_of(names, asked);
  if (clip != kNoIndex && clip >= names.size())
    return Status::invalid_argument("--animation " + asked + ": the scene has " +
                                    listed(names, kNoIndex) + "; or say all, or none");
  auto played = std::make_shared<const SceneAnimation>(with_clip(*scene.animation, clip));
  char seconds[32];
  std::snprintf(seconds, sizeof(seconds), "%.3g s", played->duration_seconds());
  std::string line = clip == kNoIndex ? std::to_string(names.size()) + " animations at once"
                                      : "animation '" + names[clip] + "'";
  line += std::string(", ") + seconds;
  if (clip != kNoIndex && names.size() > 1)
    line += "; others: " + listed(names, clip) + " (--animation)";
  scene.animation = std::move(played);
  return line;
}

}  // namespace tessera::master
