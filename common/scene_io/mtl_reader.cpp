#include "common/scene_io/mtl_reader.h"

#include <cmath>
#include <limits>

#include "common/base/limits.h"

namespace tessera {
namespace {

constexpr float kAnything = std::numeric_limits<float>::max();

bool is_any_of(int illum, std::initializer_list<int> list) {
  for (const int i : list) {
    if (i == illum) return true;
  }
  return false;
}

bool is_black(Vec3f c) { return !(c.x > 0 || c.y > 0 || c.z > 0); }

}  // namespace

void MtlReader::read(const std::string& path, std::string_view text) {
  path_ = path;
  material_ = nullptr;
  TextScanner scanner(text);
  while (scanner.next_line()) {
    line_number_ = scanner.line_number();
    read_line(scanner);
  }
  finish_material();
}

std::optional<std::uint32_t> MtlReader::find(const std::string& name) const {
  const auto known = index_.find(name);
  return known == index_.end() ? std::nullopt : std::optional(known->second);
}

void MtlReader::warn(const std::string& text) {
  result_.warnings.push_back(path_ + ":" + std::to_string(line_number_) + ": " + text);
}

void MtlReader::warn_unknown(const std::string& name) {
  if (unknown_.insert(name).second) warn("'" + name + "' is not understood and left out");
}

void MtlReader::begin_material(const std::string& name) {
  finish_material();
  auto& materials = result_.scene.materials;
  material_ = nullptr;
  lines_ = {};
  if (materials.size() >= kMaterialsMax) return;
  index_[name] = static_cast<std::uint32_t>(materials.size());
  material_ = &materials.emplace_back();
  material_->name = name.substr(0, 256);
}

void MtlReader::read_line(TextScanner& line) {
  static const std::set<std::string, std::less<>> kSilent = {
      "Ka",       "Tr",     "Ps",     "map_Ka",    "map_Bump", "bump", "map_d",
      "map_bump", "map_Ks", "map_Ns", "sharpness", "map_refl", "refl"};
  const std::string key(line.word());
  if (key.empty()) return;
  if (key.front() == '#') {
    if (key == "#" && line.word() == "tessera") read_surface(line);
    return;
  }
  if (key == "newmtl") return begin_material(std::string(line.trimmed_rest_of_line()));
  if (material_ == nullptr) return warn("'" + key + "' before the first newmtl is left out");
  if (read_light(line, key) || read_scattering(line, key) || kSilent.contains(key)) return;
  warn_unknown(key);
}

// Returns: whether it was one of these lines.
bool MtlReader::read_light(TextScanner& line, const std::string& key) {
  if (key == "Kd") {
    read_colour(line, key, 1, material_->albedo);
  } else if (key == "Ke") {
    read_colour(line, key, kAnything, material_->emission);
  } else if (key == "map_Kd") {
    set_texture(std::string(line.trimmed_rest_of_line()));
  } else {
    return false;
  }
  return true;
}

bool MtlReader::read_scattering(TextScanner& line, const std::string& key) {
  if (key == "Ks" || key == "Tf") {
    Vec3f colour{-1, -1, -1};
    read_colour(line, key, 1, colour);
    if (colour.x >= 0) (key == "Ks" ? lines_.ks : lines_.tf) = colour;
  } else if (key == "Ns") {
    read_number(line, key, 0, kAnything, lines_.ns);
  } else if (key == "Ni") {
    read_number(line, key, kIorMin, kIorMax, lines_.ni);
  } else if (key == "d") {
    read_number(line, key, 0, 1, lines_.d);
  } else if (key == "Pr" || key == "Pm") {
    read_number(line, key, 0, 1, key == "Pr" ? lines_.pr : lines_.pm);
  } else if (key == "illum") {
    const std::string number(line.word());
    lines_.illum = TextScanner::number_of<int>(number).value_or(-1);
    if (!is_any_of(lines_.illum, {0, 1, 2, 3, 5, 7})) warn_unknown("illum " + number);
  } else {
    return false;
  }
  return true;
}

// One number stands for three. What is above `high` is taken for it.
void MtlReader::read_colour(TextScanner& line, const std::string& key, float high, Vec3f& colour) {
  const auto r = line.number<float>(), g = line.number<float>(), b = line.number<float>();
  const Vec3f c{r.value_or(-1), g.value_or(r.value_or(-1)), b.value_or(r.value_or(-1))};
  if (!is_finite(c) || !(c.x >= 0 && c.y >= 0 && c.z >= 0))
    return warn("'" + key + "' needs colours from 0; it is left out");
  colour = min(c, Vec3f{high, high, high});
}

void MtlReader::read_number(TextScanner& line, const std::string& key, float low, float high,
                            std::optional<float>& number) {
  const auto x = line.number<float>();
  if (!x || !std::isfinite(*x) || *x < 0)
    return warn("'" + key + "' needs a number from 0; it is left out");
  number = std::clamp(*x, low, high);
}

void MtlReader::read_surface(TextScanner& line) {
  if (line.word() != "surface") return warn_unknown("# tessera");
  if (material_ == nullptr) return warn("'# tessera surface' before the first newmtl is left out");
  const std::string name(line.word());
  const SurfaceProgramShape* shape = find_surface_program(name);
  if (shape == nullptr) return warn_unknown("# tessera surface " + name);
  SurfaceProgram program{shape->kind, shape->defaults};
  for (std::string_view key = line.word(); !key.empty(); key = line.word()) {
    const SurfaceParameter* parameter = nullptr;
    for (const SurfaceParameter& p : shape->parameters) {
      if (p.name == key) parameter = &p;
    }
    // Without its name it cannot be told how many numbers follow.
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
    warn("surface " + name + ": '" + std::string(key) + "' needs " +
         std::to_string(parameter->count) + " numbers from " + std::to_string(parameter->low) +
         " to " + std::to_string(parameter->high) + "; its default is used");
    program = before;
  }
  material_->surface = program;
}

// Options before the name ("-s 1 1 1") are left out: the last word, unless the whole rest is a
// file.
void MtlReader::set_texture(std::string name) {
  if (!name.empty() && name.front() == '-') name = name.substr(name.find_last_of(" \t") + 1);
  for (char& c : name) c = c == '\\' ? '/' : c;
  const auto known = texture_index_.find(name);
  if (known != texture_index_.end()) {
    material_->albedo_texture = known->second;
    return;
  }
  std::uint32_t index = kNoTexture;
  auto texture =
      load_texture_
          ? load_texture_(name)
          : Result<std::shared_ptr<const Texture>>(Status::unimplemented("no textures here"));
  if (texture.is_ok()) {
    index = static_cast<std::uint32_t>(result_.scene.textures.size());
    result_.scene.textures.push_back(*texture);
  } else {
    result_.warnings.push_back("texture " + name + ": " + texture.status().message() +
                               "; the plain colour is used");
  }
  texture_index_[name] = index;
  material_->albedo_texture = index;
}

void MtlReader::finish_material() {
  if (material_ == nullptr) return;
  const bool has_highlight = lines_.ks && !is_black(*lines_.ks);
  if (lines_.illum == 7 || (lines_.d.value_or(1) < 1 && lines_.ni)) {
    const Vec3f body = lines_.tf.value_or(Vec3f{1, 1, 1});
    material_->bsdf = BsdfKind::kGlass;
    material_->ior = lines_.ni.value_or(1.5f);
    material_->specular = {std::sqrt(body.x), std::sqrt(body.y), std::sqrt(body.z)};
  } else if (is_any_of(lines_.illum, {3, 5}) && has_highlight) {
    material_->bsdf = BsdfKind::kMirror;
    material_->specular = *lines_.ks;
  } else if (lines_.pr || lines_.pm) {
    material_->bsdf = BsdfKind::kGlossy;
    material_->roughness = lines_.pr.value_or(1);
    material_->metalness = lines_.pm.value_or(0);
  } else if (has_highlight && lines_.ns && !is_any_of(lines_.illum, {0, 1})) {
    material_->bsdf = BsdfKind::kGlossy;
    material_->specular = *lines_.ks;
    material_->roughness = std::sqrt(std::sqrt(2 / (*lines_.ns + 2)));
  }
}

}  // namespace tessera
