// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/mtl_texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/scene_io/text_scanner.h"

namespace tessera {
namespace {

constexpr std::array<std::string_view, 13> kOptions = {
    "-s",     "-o",      "-t",      "-mm", "-bm",      "-boost", "-texres",
    "-clamp", "-blendu", "-blendv", "-cc", "-imfchan", "-type"};

bool is_option(std::string_view word) {
  return std::find(kOptions.begin(), kOptions.end(), word) != kOptions.end();
}

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// Takes options off the front of a text.
class OptionReader {
 public:
  // `has_name`: the last word is a picture's name, whatever it looks like.
  OptionReader(PictureUse& texture, std::string_view text, bool has_name)
      : texture_(texture), rest_(trimmed(text)), has_name_(has_name) {}

  // Returns: whether the text began with an option, which is gone then.
  bool read_one() {
    const std::string_view word = first_word();
    if (!is_option(word)) return false;
    drop_word();
    if (word == "-s" || word == "-o" || word == "-t") {
      read_vector(word);
    } else if (word == "-mm") {
      const auto base = number(), gain = number();
      if (base && gain) texture_.base = *base, texture_.gain = *gain;
    } else if (word == "-bm") {
      if (const auto bump = number()) texture_.bump = *bump;
    } else if (word == "-clamp" || word == "-blendu" || word == "-blendv" || word == "-cc") {
      read_switch(word, std::string(take()));
    } else if (word == "-imfchan") {
      read_channel(std::string(take()));
    } else {
      texture_.not_drawn.push_back(std::string(word));
      (void)take();
    }
    return true;
  }

  // Must be called after the last option.
  void finish() {
    texture_.is_nearest = texture_.is_nearest || (is_u_off_ && is_v_off_);
    if (is_u_off_ != is_v_off_) texture_.not_drawn.push_back(is_u_off_ ? "-blendu" : "-blendv");
  }

  std::string_view rest() const { return rest_; }

 private:
  std::string_view first_word() const { return rest_.substr(0, rest_.find_first_of(" \t")); }
  void drop_word() { rest_ = trimmed(rest_.substr(first_word().size())); }
  std::string_view take() {
    const std::string_view word = first_word();
    drop_word();
    return word;
  }
  // Returns: nothing for what is no finite number, or is the picture's name.
  std::optional<float> number() {
    const std::string_view word = first_word();
    const auto value = TextScanner::number_of<float>(word);
    if (!value || (has_name_ && word.size() == rest_.size())) return std::nullopt;
    drop_word();
    if (std::isfinite(*value)) return value;
    texture_.not_drawn.push_back(std::string(word));
    return std::nullopt;
  }
  void read_vector(std::string_view option) {
    const bool is_scale = option == "-s";
    const auto u = number();
    const auto v = u ? number() : std::nullopt;
    const auto w = v ? number() : std::nullopt;
    (void)w;  // pictures are flat
    if (option == "-t") {
      texture_.not_drawn.push_back("-t");
    } else if (u) {
      Vec2f& pair = is_scale ? texture_.scale : texture_.offset;
      pair.x = *u;
      if (v) pair.y = *v;
    }
  }
  void read_switch(std::string_view option, const std::string& value) {
    const bool is_on = value == "on";
    if (!is_on && value != "off") {
      texture_.not_drawn.push_back(std::string(option) + " " + value);
    } else if (option == "-clamp") {
      texture_.wrap_u = texture_.wrap_v = is_on ? TextureWrap::kClamp : TextureWrap::kRepeat;
    } else if (option == "-cc") {
      if (is_on) texture_.not_drawn.push_back("-cc");
    } else {
      (option == "-blendu" ? is_u_off_ : is_v_off_) = !is_on;
    }
  }
  void read_channel(const std::string& value) {
    if (value.size() == 1 && std::string_view("rgbmlz").find(value[0]) != std::string_view::npos) {
      texture_.channel = value[0];
    } else {
      texture_.not_drawn.push_back("-imfchan " + value);
    }
  }

  PictureUse& texture_;
  std::string_view rest_;
  const bool has_name_;
  bool is_u_off_ = false, is_v_off_ = false;
};

// Returns: where options begin behind a name, as some programs write them; the end of the text
// where there are none.
std::size_t trailing_options(std::string_view text) {
  for (std::size_t at = text.find(" -"); at != std::string_view::npos;
       at = text.find(" -", at + 1)) {
    const std::string_view rest = text.substr(at + 1);
    if (is_option(rest.substr(0, rest.find_first_of(" \t")))) return at;
  }
  return text.size();
}

}  // namespace

PictureUse parse_mtl_texture(const std::string& key, std::uint64_t line, std::string_view text) {
  PictureUse texture;
  texture.where = "line " + std::to_string(line) + ": " + key;
  OptionReader front(texture, text, true);
  while (front.read_one()) {
  }
  front.finish();
  std::string_view name = front.rest();
  // The text begins with an unknown option, whose arguments cannot be told from the picture's name.
  if (name.starts_with('-')) {
    const std::string_view option = name.substr(0, name.find_first_of(" \t"));
    texture.not_drawn.push_back(std::string(option));
    name = name.substr(name.find_last_of(" \t") == name.npos ? 0 : name.find_last_of(" \t") + 1);
  }
  if (const std::size_t end = trailing_options(name); end < name.size()) {
    OptionReader back(texture, name.substr(end), false);
    while (back.read_one()) {
    }
    back.finish();
    name = trimmed(name.substr(0, end));
  }
  texture.name = std::string(name);
  std::replace(texture.name.begin(), texture.name.end(), '\\', '/');
  return texture;
}

}  // namespace tessera
