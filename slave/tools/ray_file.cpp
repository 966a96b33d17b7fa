// SPDX-License-Identifier: Apache-2.0
#include "slave/tools/ray_file.h"

#include <bit>
#include <filesystem>

#include "common/base/path_suffix.h"
#include "common/scene_io/text_scanner.h"

namespace tessera::tools {
namespace {

constexpr std::size_t kFloats = 8;
constexpr std::size_t kLineBytesMax = 4096;

core::CastRay ray_of(const float* v) {
  return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, v[6], v[7]};
}

}  // namespace

Result<RayFile> RayFile::open(const std::string& path) {
  RayFile rays;
  rays.path_ = path;
  rays.is_csv_ = suffix_of(path) == ".csv";
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return Status::not_found(path + ": " + error.message() + "; give a file of rays");
  if (!rays.is_csv_ && size % (kFloats * sizeof(float)) != 0) {
    return Status::invalid_argument(
        path +
        ": is not a whole number of rays of 32 bytes (8 float32 each); text needs the name "
        "ending .csv");
  }
  rays.file_.open(path, std::ios::binary);
  if (!rays.file_) return Status::not_found(path + ": cannot be read");
  return rays;
}

Result<std::vector<core::CastRay>> RayFile::read(std::size_t count_max) {
  std::vector<core::CastRay> rays;
  if (!is_csv_) {
    static_assert(std::endian::native == std::endian::little);
    std::vector<float> values(count_max * kFloats);
    file_.read(reinterpret_cast<char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(float)));
    const std::size_t count = static_cast<std::size_t>(file_.gcount()) / (kFloats * sizeof(float));
    for (std::size_t i = 0; i < count; ++i) rays.push_back(ray_of(&values[i * kFloats]));
    return rays;
  }
  std::string line;
  while (rays.size() < count_max && std::getline(file_, line)) {
    ++line_;
    TESSERA_RETURN_IF_ERROR(read_line(line, rays));
  }
  return rays;
}

Status RayFile::read_line(const std::string& line, std::vector<core::CastRay>& rays) {
  const auto wrong = [&](const char* what) {
    return Status::invalid_argument(path_ + ", line " + std::to_string(line_) + ": " + what);
  };
  if (line.size() > kLineBytesMax) return wrong("is longer than a ray can be");
  if (line.find_first_not_of(" \t\r") == std::string::npos) return Status::ok();
  float values[kFloats];
  std::size_t begin = 0;
  for (std::size_t k = 0; k < kFloats; ++k) {
    if (begin > line.size()) return wrong("needs 8 numbers: ox,oy,oz,dx,dy,dz,tmin,tmax");
    const std::size_t end = std::min(line.find(',', begin), line.size());
    TextScanner field(std::string_view(line).substr(begin, end - begin));
    field.next_line();
    const auto value = TextScanner::number_of<float>(field.trimmed_rest_of_line());
    if (!value) {
      const bool is_header = line_ == 1 && k == 0;
      return is_header ? Status::ok() : wrong("holds something that is no number");
    }
    values[k] = *value;
    begin = end + 1;
  }
  if (begin <= line.size()) return wrong("holds more than 8 numbers");
  rays.push_back(ray_of(values));
  return Status::ok();
}

}  // namespace tessera::tools
