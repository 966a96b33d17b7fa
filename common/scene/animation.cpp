// SPDX-License-Identifier: Apache-2.0
#include "common/scene/animation.h"

#include <algorithm>

namespace tessera {

std::vector<std::string> SceneAnimation::clip_names() const {
  std::vector<std::string> all;
  std::size_t first = 0;
  for (const MotionClip& clip : clips) {
    all.emplace_back(names.data() + first, clip.name_bytes);
    first += clip.name_bytes;
  }
  return all;
}

double SceneAnimation::duration_seconds() const {
  float last = 0;
  for (const MotionChannel& channel : channels)
    last = std::max(last, key_seconds[channel.first_key + channel.key_count - 1]);
  return static_cast<double>(last);
}

SceneAnimation with_clip(const SceneAnimation& animation, std::uint32_t clip) {
  SceneAnimation result = animation;
  if (animation.clips.empty()) return result;
  result.channels.clear();
  result.key_seconds.clear();
  result.key_values.clear();
  std::uint32_t first_channel = 0;
  for (std::uint32_t i = 0; i < animation.clips.size(); ++i) {
    const std::uint32_t count = animation.clips[i].channel_count;
    if (clip == kNoIndex || clip == i) {
      result.channels.insert(result.channels.end(), animation.channels.begin() + first_channel,
                             animation.channels.begin() + first_channel + count);
    }
    first_channel += count;
  }
  for (MotionChannel& channel : result.channels) {
    const std::size_t values = channel.key_count * channel_width(animation, channel);
    const auto key = animation.key_seconds.begin() + channel.first_key;
    const auto value = animation.key_values.begin() + channel.first_value;
    channel.first_key = static_cast<std::uint32_t>(result.key_seconds.size());
    channel.first_value = static_cast<std::uint32_t>(result.key_values.size());
    result.key_seconds.insert(result.key_seconds.end(), key, key + channel.key_count);
    result.key_values.insert(result.key_values.end(), value,
                             value + static_cast<std::ptrdiff_t>(values));
  }
  const std::string name = clip == kNoIndex ? "all" : animation.clip_names()[clip];
  result.names.assign(name.begin(), name.end());
  result.clips = {{static_cast<std::uint32_t>(result.channels.size()),
                   static_cast<std::uint32_t>(name.size())}};
  return result;
}

std::size_t value_width(const SceneAnimation& animation, const MotionChannel& channel) {
  switch (channel.path) {
    case MotionPath::kRotation:
      return 4;
    case MotionPath::kWeights:
      return animation.nodes[channel.node].weight_count;
    case MotionPath::kTranslation:
    case MotionPath::kScale:
      break;
  }
  return 3;
}

std::size_t channel_width(const SceneAnimation& animation, const MotionChannel& channel) {
  return value_width(animation, channel) * (channel.curve == KeyCurve::kCubic ? 3 : 1);
}

}  // namespace tessera
