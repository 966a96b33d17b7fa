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

// The sRGB curve of IEC 61966-2-1. Written so that NaN becomes black.
constexpr const char* kFragmentText = R"(#version 330 core
in vec2 place;
out vec4 shown;
uniform sampler2D picture;
uniform sampler2D tint;
uniform vec2 picture_px;
uniform float tile_px;
uniform float tint_weight;
uniform bool is_linear;
float encoded(float x) {
  x = x > 0.0 ? min(x, 1.0) : 0.0;
  return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}
void main() {
  vec3 c = texture(picture, place).rgb;
  if (is_linear) c = vec3(encoded(c.r), encoded(c.g), encoded(c.b));
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

class GlPicture final : public PictureGl {
 public:
  Status start();
  ~GlPicture() override;
  int side_max_px() const override { return side_max_px_; }
  Status show(const FrameImage& image) override;
  void draw(PixelSize window, bool tints_tiles) override;
  FrameImage read_back(PixelSize window) override;

 private:
  void upload_tint(const FrameImage& image);

  GLuint program_ = 0, vertices_ = 0, picture_ = 0, tint_ = 0;
  GLint at_picture_px_ = -1, at_tile_px_ = -1, at_tint_weight_ = -1, at_is_linear_ = -1;
  int side_max_px_ = 0;
  PixelSize size_;  // of the picture; 0 before the first
  PixelFormat format_ = PixelFormat::kFloat;
  int tile_px_ = 0;
  bool has_tint_ = false;
};

Status GlPicture::start() {
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side_max_px_);
  Result<GLuint> vertex = compile(GL_VERTEX_SHADER, kVertexText);
  if (!vertex.is_ok()) return vertex.status();
  Result<GLuint> fragment = compile(GL_FRAGMENT_SHADER, kFragmentText);
  if (!fragment.is_ok()) {
    glDeleteShader(*vertex);
    return fragment.status();
  }
  program_ = glCreateProgram();
  glAttachShader(program_, *vertex);
  glAttachShader(program_, *fragment);
  glLinkProgram(program_);
  glDeleteShader(*vertex);
  glDeleteShader(*fragment);
  GLint is_linked = GL_FALSE;
  glGetProgramiv(program_, GL_LINK_STATUS, &is_linked);
  if (is_linked != GL_TRUE) {
    return Status::unavailable("the OpenGL driver cannot link the viewer's shaders: update it");
  }
  at_picture_px_ = glGetUniformLocation(program_, "picture_px");
  at_tile_px_ = glGetUniformLocation(program_, "tile_px");
  at_tint_weight_ = glGetUniformLocation(program_, "tint_weight");
  at_is_linear_ = glGetUniformLocation(program_, "is_linear");
  glUseProgram(program_);
  glUniform1i(glGetUniformLocation(program_, "picture"), 0);
  glUniform1i(glGetUniformLocation(program_, "tint"), 1);
  glGenVertexArrays(1, &vertices_);  // a core context draws nothing without one
  for (GLuint* texture : {&picture_, &tint_}) {
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
  glDeleteProgram(program_);
  glDeleteVertexArrays(1, &vertices_);
  glDeleteTextures(1, &picture_);
  glDeleteTextures(1, &tint_);
}

Status GlPicture::show(const FrameImage& image) {
  if (image.width_px < 1 || image.height_px < 1 ||
      image.bytes.size() != static_cast<std::size_t>(image.width_px) *
                                static_cast<std::size_t>(image.height_px) *
                                static_cast<std::size_t>(bytes_per_pixel(image.format))) {
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
  format_ = image.format;
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

void GlPicture::draw(PixelSize window, bool tints_tiles) {
  glViewport(0, 0, window.width_px, window.height_px);
  glClearColor(kBorderGrey, kBorderGrey, kBorderGrey, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  if (size_.width_px == 0) return;
  const PixelRect r = letterbox(size_, window);
  // OpenGL counts rows from below.
  glViewport(r.x_px, window.height_px - r.y_px - r.height_px, r.width_px, r.height_px);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, tint_);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, picture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                  r.width_px < size_.width_px ? GL_LINEAR : GL_NEAREST);
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glUseProgram(program_);
  glUniform2f(at_picture_px_, static_cast<float>(size_.width_px),
              static_cast<float>(size_.height_px));
  glUniform1f(at_tile_px_, static_cast<float>(std::max(1, tile_px_)));
  glUniform1f(at_tint_weight_, tints_tiles && has_tint_ ? kTintWeight : 0.0f);
  glUniform1i(at_is_linear_, format_ != PixelFormat::kDisplay8);
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
