// SPDX-License-Identifier: Apache-2.0
#include "master/display/picture_gl.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/frame/tile_grid.h"

namespace tessera::master {

namespace {

constexpr const char* kVertexText = R"(#version 330 core
out vec2 place;  // [0, 1], row 0 on top
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
  place = vec2(corner.x, 1.0 - corner.y);
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
)";

// First pass: what the display is given for each pixel of the picture. The sRGB curve is that of
// IEC 61966-2-1, written so that NaN becomes black.
constexpr const char* kTonedText = R"(#version 330 core
out vec4 shown;
uniform sampler2D picture;
uniform bool is_linear;
uniform float gain;
uniform bool has_curve;
uniform mat3 curve_in, curve_out;
uniform sampler2D curve;
uniform vec2 curve_range;  // binary logarithms of the first and the last sample
float bent(float x) {
  float at = (log2(max(x, 1e-12)) - curve_range.x) / (curve_range.y - curve_range.x);
  float samples = float(textureSize(curve, 0).x);
  return texture(curve, vec2((clamp(at, 0.0, 1.0) * (samples - 1.0) + 0.5) / samples, 0.5)).r;
}
vec3 toned(vec3 c) {
  c *= gain;
  if (!has_curve) return c;
  c = curve_in * max(c, vec3(0.0));
  return curve_out * vec3(bent(c.r), bent(c.g), bent(c.b));
}
float encoded(float x) {
  x = x > 0.0 ? min(x, 1.0) : 0.0;
  return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}
void main() {
  vec3 c = texelFetch(picture, ivec2(gl_FragCoord.xy), 0).rgb;
  if (is_linear) {
    c = toned(c);
    c = vec3(encoded(c.r), encoded(c.g), encoded(c.b));
  }
  shown = vec4(c, 1.0);
}
)";

// Second pass: these pixels in their place in the window, tinted by slave on request.
constexpr const char* kPlacedText = R"(#version 330 core
in vec2 place;
out vec4 shown;
uniform sampler2D displayed;
uniform sampler2D tint;
uniform vec2 picture_px;
uniform float tile_px;
uniform float tint_weight;
uniform bool is_magnified;
vec3 pixel(ivec2 at) { return texelFetch(displayed, clamp(at, ivec2(0), ivec2(picture_px) - 1), 0).rgb; }
// By hand: texture units have 8 bits for the place between two pixels.
vec3 between_pixels() {
  vec2 from_middle = place * picture_px - 0.5;
  vec2 corner = floor(from_middle);
  vec2 share = from_middle - corner;
  ivec2 at = ivec2(corner);
  vec3 upper = mix(pixel(at), pixel(at + ivec2(1, 0)), share.x);
  vec3 lower = mix(pixel(at + ivec2(0, 1)), pixel(at + ivec2(1, 1)), share.x);
  return mix(upper, lower, share.y);
}
void main() {
  vec3 c = is_magnified ? between_pixels() : texture(displayed, place).rgb;
  if (tint_weight > 0.0) {
    ivec2 tile = ivec2(clamp(place * picture_px, vec2(0.0), picture_px - 1.0) / tile_px);
    c = mix(c, texelFetch(tint, tile, 0).rgb, tint_weight);
  }
  shown = vec4(c, 1.0);
}
)";

constexpr float kBorderGrey = 0.1f;  // beside the picture, sRGB-encoded

struct TextureFormat {
  GLint internal;
  GLenum type;
};

TextureFormat texture_format(PixelFormat format) {
  switch (format) {
    case PixelFormat::kFloat:
      return {GL_RGB32F, GL_FLOAT};
    case PixelFormat::kHalf:
      return {GL_RGB16F, GL_HALF_FLOAT};
    case PixelFormat::kDisplay8:
      break;
  }
  return {GL_RGB8, GL_UNSIGNED_BYTE};
}

Result<GLuint> compile(GLenum stage, const char* text) {
  const GLuint shader = glCreateShader(stage);
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint is_compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &is_compiled);
  if (is_compiled == GL_TRUE) return shader;
  char words[512] = {};
  glGetShaderInfoLog(shader, sizeof words, nullptr, words);
  glDeleteShader(shader);
  return Status::unavailable(std::string("the OpenGL driver refuses the viewer's shader: ") +
                             words);
}

Result<GLuint> link(const char* fragment_text) {
  const Result<GLuint> vertex = compile(GL_VERTEX_SHADER, kVertexText);
  if (!vertex.is_ok()) return vertex.status();
  const Result<GLuint> fragment = compile(GL_FRAGMENT_SHADER, fragment_text);
  if (!fragment.is_ok()) {
    glDeleteShader(*vertex);
    return fragment.status();
  }
  const GLuint program = glCreateProgram();
  glAttachShader(program, *vertex);
  glAttachShader(program, *fragment);
  glLinkProgram(program);
  glDeleteShader(*vertex);
  glDeleteShader(*fragment);
  GLint is_linked = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &is_linked);
  if (is_linked == GL_TRUE) return program;
  glDeleteProgram(program);
  return Status::unavailable("the OpenGL driver cannot link the viewer's shaders: update it");
}

class GlPicture final : public PictureGl {
 public:
  Status start();
  ~GlPicture() override;
  int side_max_px() const override { return side_max_px_; }
  Status show(const FrameImage& image, PixelSize stands_for) override;
  void set_display(const DisplayTransform& display) override;
  void draw(PixelSize window, bool tints_tiles) override;
  FrameImage read_back(PixelSize window) override;

 private:
  void upload_tint(const FrameImage& image);
  void clear(PixelSize window);
  void tone(GLint format);

  GLuint toning_ = 0, placing_ = 0, vertices_ = 0, picture_ = 0, tint_ = 0, curve_ = 0;
  GLuint displayed_ = 0, into_displayed_ = 0;
  GLint at_is_linear_ = -1, at_gain_ = -1, at_has_curve_ = -1;
  GLint at_picture_px_ = -1, at_tile_px_ = -1, at_tint_weight_ = -1, at_is_magnified_ = -1;
  DisplayTransform display_;
  int side_max_px_ = 0;
  PixelSize size_;        // of the picture; 0 before the first
  PixelSize toned_size_;  // of displayed_
  GLint toned_format_ = 0;
  bool is_toned_ = false;  // displayed_ shows this picture by display_
  PixelSize stands_for_;   // size of the picture whose place it fills
  PixelFormat format_ = PixelFormat::kFloat;
  int tile_px_ = 0;
  bool has_tint_ = false;
};

Status GlPicture::start() {
  GLint viewport_max_px[2] = {};
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side_max_px_);
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport_max_px);
  side_max_px_ = std::min({side_max_px_, viewport_max_px[0], viewport_max_px[1]});
  const Result<GLuint> toning = link(kTonedText);
  if (!toning.is_ok()) return toning.status();
  toning_ = *toning;
  const Result<GLuint> placing = link(kPlacedText);
  if (!placing.is_ok()) return placing.status();
  placing_ = *placing;
  at_is_linear_ = glGetUniformLocation(toning_, "is_linear");
  at_gain_ = glGetUniformLocation(toning_, "gain");
  at_has_curve_ = glGetUniformLocation(toning_, "has_curve");
  glUseProgram(toning_);
  glUniform1i(glGetUniformLocation(toning_, "picture"), 0);
  glUniform1i(glGetUniformLocation(toning_, "curve"), 1);
  glUniform2f(glGetUniformLocation(toning_, "curve_range"), ToneTable::kLowEv, ToneTable::kHighEv);
  at_picture_px_ = glGetUniformLocation(placing_, "picture_px");
  at_tile_px_ = glGetUniformLocation(placing_, "tile_px");
  at_tint_weight_ = glGetUniformLocation(placing_, "tint_weight");
  at_is_magnified_ = glGetUniformLocation(placing_, "is_magnified");
  glUseProgram(placing_);
  glUniform1i(glGetUniformLocation(placing_, "displayed"), 0);
  glUniform1i(glGetUniformLocation(placing_, "tint"), 1);
  glGenVertexArrays(1, &vertices_);  // a core context draws nothing without one
  glGenFramebuffers(1, &into_displayed_);
  for (GLuint* texture : {&picture_, &tint_, &curve_, &displayed_}) {
    glGenTextures(1, texture);
    glBindTexture(GL_TEXTURE_2D, *texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  return Status::ok();
}

GlPicture::~GlPicture() {
  glDeleteProgram(toning_);
  glDeleteProgram(placing_);
  glDeleteVertexArrays(1, &vertices_);
  glDeleteFramebuffers(1, &into_displayed_);
  glDeleteTextures(1, &picture_);
  glDeleteTextures(1, &tint_);
  glDeleteTextures(1, &curve_);
  glDeleteTextures(1, &displayed_);
}

void GlPicture::set_display(const DisplayTransform& display) {
  const bool is_new = display.tone != display_.tone;
  is_toned_ = is_toned_ && display == display_;
  display_ = display;
  if (!is_new || display.tone == ToneCurve::kLinear) return;
  const ToneTable table = tone_table(display.tone);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, curve_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, ToneTable::kSamples, 1, 0, GL_RED, GL_FLOAT, table.of);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glUseProgram(toning_);
  glUniformMatrix3fv(glGetUniformLocation(toning_, "curve_in"), 1, GL_TRUE, &table.in[0][0]);
  glUniformMatrix3fv(glGetUniformLocation(toning_, "curve_out"), 1, GL_TRUE, &table.out[0][0]);
}

Status GlPicture::show(const FrameImage& image, PixelSize stands_for) {
  if (image.width_px < 1 || image.height_px < 1 ||
      image.bytes.size() != image.pixel_count() * image.layout().pixel_bytes()) {
    return Status::internal("a frame's bytes do not fit its size");
  }
  if (image.width_px > side_max_px_ || image.height_px > side_max_px_) {
    return Status::resource_exhausted(
        "a frame of " + std::to_string(image.width_px) + "x" + std::to_string(image.height_px) +
        " is larger than the display's textures (" + std::to_string(side_max_px_) + ")");
  }
  const PixelSize size{image.width_px, image.height_px};
  const TextureFormat texture = texture_format(image.format);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, picture_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);  // rows of RGB are packed
  if (size == size_ && image.format == format_) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size.width_px, size.height_px, GL_RGB, texture.type,
                    image.bytes.data());
  } else {
    glTexImage2D(GL_TEXTURE_2D, 0, texture.internal, size.width_px, size.height_px, 0, GL_RGB,
                 texture.type, image.bytes.data());
  }
  size_ = size;
  stands_for_ = stands_for.width_px > 0 && stands_for.height_px > 0 ? stands_for : size;
  format_ = image.format;
  is_toned_ = false;
  upload_tint(image);
  return Status::ok();
}

void GlPicture::upload_tint(const FrameImage& image) {
  has_tint_ = false;
  if (image.tile_edge_px < 1 || image.tile_slave.empty()) return;
  const TileGrid grid(image.width_px, image.height_px, image.tile_edge_px);
  if (image.tile_slave.size() != grid.tile_count()) return;
  std::vector<float> colours;
  colours.reserve(image.tile_slave.size() * 3);
  for (const std::uint16_t ordinal : image.tile_slave) {
    for (const float channel : slave_colour(ordinal)) colours.push_back(channel);
  }
  const int columns = (image.width_px + image.tile_edge_px - 1) / image.tile_edge_px;
  const int rows = static_cast<int>(grid.tile_count()) / columns;
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, tint_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, columns, rows, 0, GL_RGB, GL_FLOAT, colours.data());
  tile_px_ = image.tile_edge_px;
  has_tint_ = true;
}

// Fills displayed_ with the picture as the display shows it.
void GlPicture::tone(GLint format) {
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, displayed_);
  if (toned_size_ != size_ || toned_format_ != format) {
    glTexImage2D(GL_TEXTURE_2D, 0, format, size_.width_px, size_.height_px, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, nullptr);
    toned_size_ = size_;
    toned_format_ = format;
  }
  glBindFramebuffer(GL_FRAMEBUFFER, into_displayed_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, displayed_, 0);
  glViewport(0, 0, size_.width_px, size_.height_px);
  glBindTexture(GL_TEXTURE_2D, picture_);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, curve_);
  glUseProgram(toning_);
  glUniform1f(at_gain_, std::exp2(display_.exposure_ev));
  glUniform1i(at_has_curve_, display_.tone != ToneCurve::kLinear);
  glUniform1i(at_is_linear_, format_ != PixelFormat::kDisplay8);
  glBindVertexArray(vertices_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  is_toned_ = true;
}

void GlPicture::clear(PixelSize window) {
  glViewport(0, 0, window.width_px, window.height_px);
  glClearColor(kBorderGrey, kBorderGrey, kBorderGrey, 1);
  glClear(GL_COLOR_BUFFER_BIT);
}

void GlPicture::draw(PixelSize window, bool tints_tiles) {
  if (size_.width_px == 0) return clear(window);
  const PixelRect r = letterbox(stands_for_, window);
  const bool is_magnified = r.width_px > size_.width_px || r.height_px > size_.height_px;
  // A magnified picture is rounded to the display's 8 bits after it is interpolated.
  const GLint format = is_magnified ? GL_RGBA16 : GL_RGBA8;
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  if (!(is_toned_ && toned_format_ == format)) tone(format);
  clear(window);
  // OpenGL counts rows from below.
  glViewport(r.x_px, window.height_px - r.y_px - r.height_px, r.width_px, r.height_px);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, tint_);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, displayed_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                  r.width_px < size_.width_px ? GL_LINEAR : GL_NEAREST);
  glUseProgram(placing_);
  glUniform2f(at_picture_px_, static_cast<float>(size_.width_px),
              static_cast<float>(size_.height_px));
  glUniform1f(at_tile_px_, static_cast<float>(std::max(1, tile_px_)));
  glUniform1i(at_is_magnified_, is_magnified);
  glUniform1f(at_tint_weight_, tints_tiles && has_tint_ ? kTintWeight : 0.0f);
  glBindVertexArray(vertices_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glViewport(0, 0, window.width_px, window.height_px);
}

FrameImage GlPicture::read_back(PixelSize window) {
  FrameImage image;
  image.width_px = window.width_px;
  image.height_px = window.height_px;
  image.format = PixelFormat::kDisplay8;
  const std::size_t row_bytes = static_cast<std::size_t>(window.width_px) * 3;
  const std::size_t row_count = static_cast<std::size_t>(window.height_px);
  std::vector<std::byte> upward(row_bytes * row_count);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, window.width_px, window.height_px, GL_RGB, GL_UNSIGNED_BYTE, upward.data());
  image.bytes.resize(upward.size());
  for (std::size_t row = 0; row < row_count; ++row) {
    std::copy_n(upward.begin() + static_cast<std::ptrdiff_t>((row_count - 1 - row) * row_bytes),
                row_bytes, image.bytes.begin() + static_cast<std::ptrdiff_t>(row * row_bytes));
  }
  return image;
}

}  // namespace

Result<std::unique_ptr<PictureGl>> PictureGl::create() {
  auto picture = std::make_unique<GlPicture>();
  TESSERA_RETURN_IF_ERROR(picture->start());
  return std::unique_ptr<PictureGl>(std::move(picture));
}

}  // namespace tessera::master
