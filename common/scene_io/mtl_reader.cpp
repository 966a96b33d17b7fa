// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/mtl_reader.h"

#include <cmath>
#include <limits>

#include "common/base/limits.h"

namespace tessera {
namespace {

constexpr float kAnything = std::numeric_limits<float>::max();

// Returns: the one spelling that stands for all spellings of a key that takes a picture.
std::string picture_key(const std::string& key) {
  static const std::map<std::string, std::string, std::less<>> kKeys = {
      {"map_Kd", "map_Kd"}, {"map_Ks", "map_Ks"}, {"map_Ke", "map_Ke"}, {"map_ke", "map_Ke"},
      {"map_Ns", "map_Ns"}, {"map_d", "map_d"},   {"map_Pr", "map_Pr"}, {"map_Pm", "map_Pm"},
      {"map_Ps", "map_Ps"}, {"bump", "bump"},     {"Bump", "bump"},     {"map_bump", "bump"},
      {"map_Bump", "bump"}, {"norm", "norm"},     {"Norm", "norm"},     {"map_Kn", "norm"},
      {"map_norm", "norm"}, {"map_Norm", "norm"}};
  const auto known = kKeys.find(key);
  return known == kKeys.end() ? std::string() : known->second;
}

// CIE XYZ to linear Rec. 709 (IEC 61966-2-1).
Vec3f rgb_of_xyz(Vec3f c) {
  return {3.2406f * c.x - 1.5372f * c.y - 0.4986f * c.z,
          -0.9689f * c.x + 1.8758f * c.y + 0.0415f * c.z,
          0.0557f * c.x - 0.2040f * c.y + 1.0570f * c.z};
}

}  // namespace

void MtlReader::read(const std::string& path, std::string_view text) {
  warnings_.emplace(path);
  pictures_.set_warnings(&*warnings_);
  material_ = nullptr;
  passed_over_.clear();
  TextScanner scanner(text);
  while (scanner.next_line()) {
    line_number_ = scanner.line_number();
    read_line(scanner);
  }
  finish_material();
  finish_file();
}

std::optional<std::uint32_t> MtlReader::find(const std::string& name) const {
  const auto known = index_.find(name);
  return known == index_.end() ? std::nullopt : std::optional(known->second);
}

void MtlReader::warn(const std::string& kind, const std::string& text) {
  warnings_->add(kind, "line " + std::to_string(line_number_) + ": " + text);
}

void MtlReader::warn_unknown(const std::string& name) {
  warn("unknown " + name, "'" + name + "' is not understood and left out");
}

void MtlReader::begin_material(const std::string& name) {
  finish_material();
  auto& materials = result_.scene.materials;
  material_ = nullptr;
  lines_ = {};
  if (materials.size() >= kMaterialsMax)
    return warn("too many", "more than " + std::to_string(kMaterialsMax) + " materials");
  if (index_.contains(name))
    warn("twice", "material '" + name + "' is defined again; this one counts");
  index_[name] = static_cast<std::uint32_t>(materials.size());
  material_ = &materials.emplace_back();
  material_->name = name.substr(0, 256);
}

void MtlReader::read_line(TextScanner& line) {
  const std::string key(line.word());
  if (key.empty()) return;
  if (key.front() == '#') {
    if (key == "#" && line.word() == "tessera") read_extension(line);
    return;
  }
  if (key == "newmtl") return begin_material(std::string(line.trimmed_rest_of_line()));
  if (material_ == nullptr)
    return warn("before newmtl", "'" + key + "' before the first newmtl is left out");
  if (key == "illum") return read_illum(line);
  if (read_color_line(line, key) || read_number_line(line, key) || read_picture_line(line, key) ||
      pass_over(line, key)) {
    return;
  }
  warn_unknown(key);
}

// Returns: whether the line was one of a colour.
bool MtlReader::read_color_line(TextScanner& line, const std::string& key) {
  if (key == "Kd") {
    read_color(line, key, 1, lines_.kd);
  } else if (key == "Ke") {
    read_color(line, key, kAnything, lines_.ke);
  } else if (key == "Ks") {
    read_color(line, key, 1, lines_.ks);
  } else if (key == "Tf") {
    read_color(line, key, 1, lines_.tf);
  } else {
    return false;
  }
  return true;
}

bool MtlReader::read_number_line(TextScanner& line, const std::string& key) {
  struct Number {
    std::string_view key;
    float low, high;
    std::optional<float> MtlLines::*member;
  };
  static constexpr Number kNumbers[] = {
      {"Ns", 0, kAnything, &MtlLines::ns}, {"Ni", kIorMin, kIorMax, &MtlLines::ni},
      {"d", 0, 1, &MtlLines::d},           {"Tr", 0, 1, &MtlLines::tr},
      {"Pr", 0, 1, &MtlLines::pr},         {"Pm", 0, 1, &MtlLines::pm},
      {"Ps", 0, 1, &MtlLines::ps},         {"Pc", 0, 1, &MtlLines::pc},
      {"Pcr", 0, 1, &MtlLines::pcr},       {"aniso", 0, 1, &MtlLines::aniso},
      {"anisor", 0, 1, &MtlLines::anisor}};
  for (const Number& n : kNumbers) {
    if (n.key != key) continue;
    read_number(line, key, n.low, n.high, lines_.*n.member);
    return true;
  }
  return false;
}

bool MtlReader::read_picture_line(TextScanner& line, const std::string& key) {
  const std::string known = picture_key(key);
  if (known.empty()) return false;
  PictureUse texture = parse_mtl_texture(key, line_number_, line.trimmed_rest_of_line());
  if (texture.name.empty()) {
    warn("no name " + known, "'" + key + "' names no picture; it is left out");
  } else {
    lines_.pictures[known] = std::move(texture);
  }
  return true;
}

// Passes over a line whose meaning is none for a path tracer or is not drawn. All such lines give
// one warning. Returns: whether the line was one of these.
bool MtlReader::pass_over(TextScanner& line, const std::string& key) {
  static const std::map<std::string, const char*, std::less<>> kKeys = {
      {"Ka", "ambient light"},
      {"map_Ka", "ambient light"},
      {"sharpness", "reflection maps"},
      {"refl", "reflection maps"},
      {"map_refl", "reflection maps"},
      {"map_aat", "antialiasing"},
      {"disp", "displacement"},
      {"map_disp", "displacement"},
      {"decal", "decals"},
      {"map_decal", "decals"},
      {"map_Pc", "pictures of clearcoat"},
      {"map_Pcr", "pictures of clearcoat"},
      {"map_aniso", "pictures of anisotropy"},
      {"map_anisor", "pictures of anisotropy"}};
  const auto known = kKeys.find(key);
  if (known == kKeys.end()) return false;
  const bool is_black = key == "Ka" && line.number<float>() == 0 && line.number<float>() == 0 &&
                        line.number<float>() == 0;
  if (!is_black) ++passed_over_[key + " (" + known->second + ")"];
  return true;
}

// One number stands for three. Numbers above `high` are taken for `high`.
void MtlReader::read_color(TextScanner& line, const std::string& key, float high,
                           std::optional<Vec3f>& color) {
  std::string_view word = line.word();
  if (word == "spectral") {
    return warn("spectral", "'" + key +
                                " spectral' needs a file of spectra, which are not read; it "
                                "is left out");
  }
  const bool is_xyz = word == "xyz";
  if (is_xyz) word = line.word();
  const auto r = TextScanner::number_of<float>(word), g = line.number<float>(),
             b = line.number<float>();
  Vec3f c{r.value_or(-1), g.value_or(r.value_or(-1)), b.value_or(r.value_or(-1))};
  if (!is_finite(c) || !(c.x >= 0 && c.y >= 0 && c.z >= 0))
    return warn("bad " + key, "'" + key + "' needs finite colours from 0; it is left out");
  if (is_xyz) c = max(rgb_of_xyz(c), Vec3f{});
  color = min(c, Vec3f{high, high, high});
  if (*color != c) warn("above " + key, "'" + key + "' is above 1, which is taken in its place");
}

void MtlReader::read_number(TextScanner& line, const std::string& key, float low, float high,
                            std::optional<float>& number) {
  std::string_view word = line.word();
  if (key == "d" && word == "-halo") {
    warn("halo", "'d -halo', opacity by the angle of sight, is taken for plain 'd'");
    word = line.word();
  }
  const auto x = TextScanner::number_of<float>(word);
  if (!x || !std::isfinite(*x) || *x < 0)
    return warn("bad " + key, "'" + key + "' needs a finite number from 0; it is left out");
  number = std::clamp(*x, low, high);
  if (*number == *x) return;
  char range[64];
  std::snprintf(range, sizeof(range), "%g to %g; %g is taken", double{low}, double{high},
                double{*number});
  warn("range " + key, "'" + key + " " + std::string(word) + "' is out of its range, " + range);
}

void MtlReader::read_illum(TextScanner& line) {
  const std::string word(line.word());
  const int number = TextScanner::number_of<int>(word).value_or(-1);
  if (number < 0 || number > 9) return warn_unknown("illum " + word);
  lines_.illum = number;
}

void MtlReader::read_extension(TextScanner& line) {
  const std::string key(line.word());
  if (key != "surface" && key != "bsdf") return warn_unknown("# tessera");
  if (material_ == nullptr)
    return warn("before newmtl", "'# tessera " + key + "' before the first newmtl is left out");
  key == "bsdf" ? read_bsdf(line) : read_surface(line);
}

void MtlReader::read_bsdf(TextScanner& line) {
  const std::string name(line.word());
  const BsdfKind* const kind = find_bsdf(name);
  if (kind == nullptr) return warn_unknown("# tessera bsdf " + name);
  lines_.bsdf = *kind;
}

void MtlReader::read_surface(TextScanner& line) {
  const std::string name(line.word());
  const SurfaceProgramShape* shape = find_surface_program(name);
  if (shape == nullptr) return warn_unknown("# tessera surface " + name);
  SurfaceProgram program{shape->kind, shape->defaults};
  for (std::string_view key = line.word(); !key.empty(); key = line.word()) {
    const std::string key_text(key);
    const SurfaceParameter* parameter = nullptr;
    for (const SurfaceParameter& p : shape->parameters) {
      if (p.name == key) parameter = &p;
    }
    // Behind an unknown name it cannot be told how many numbers follow.
    if (parameter == nullptr) {
      warn_unknown("# tessera surface " + name + " " + std::string(key));
      break;
    }
    const SurfaceProgram before = program;
    for (std::size_t i = 0; i < parameter->count; ++i) {
      program.parameters[parameter->first + i] =
          line.number<float>().value_or(std::numeric_limits<float>::quiet_NaN());
    }
    if (first_bad_parameter(*shape, program) == nullptr) continue;
    warn("surface " + name + key_text,
         "surface " + name + ": '" + key_text + "' needs " + std::to_string(parameter->count) +
             " numbers from " + std::to_string(parameter->low) + " to " +
             std::to_string(parameter->high) + "; its default is used");
    program = before;
  }
  material_->surface = program;
}

void MtlReader::finish_material() {
  if (material_ != nullptr) apply_mtl_lines(lines_, pictures_, *warnings_, *material_);
  material_ = nullptr;
}

void MtlReader::finish_file() {
  std::string text;
  for (const auto& [key, count] : passed_over_)
    text += (text.empty() ? "" : ", ") + key + " " + std::to_string(count) + "x";
  if (!text.empty()) warnings_->add("passed over", "not drawn: " + text);
  for (std::string& line : warnings_->lines()) result_.warnings.push_back(std::move(line));
}

}  // namespace tessera
