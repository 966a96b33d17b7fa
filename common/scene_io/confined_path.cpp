// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/confined_path.h"

#include <algorithm>
#include <filesystem>

namespace tessera {

Result<std::string> confined_path(const std::string& folder, const std::string& name) {
  namespace fs = std::filesystem;
  const fs::path relative(name);
  if (relative.is_absolute() || name.find("://") != std::string::npos) {
    return Status::permission_denied("only names below the scene's folder are read");
  }
  std::error_code error;
  const fs::path root = fs::canonical(folder.empty() ? "." : folder, error);
  if (error) return Status::not_found(error.message());
  const fs::path file = fs::canonical(root / relative, error);
  if (error) return Status::not_found("no such file");
  const auto mismatch = std::mismatch(root.begin(), root.end(), file.begin(), file.end());
  if (mismatch.first != root.end()) {
    return Status::permission_denied("lies outside the scene's folder");
  }
  if (!fs::is_regular_file(file, error)) return Status::permission_denied("is not a regular file");
  return file.string();
}

}  // namespace tessera
