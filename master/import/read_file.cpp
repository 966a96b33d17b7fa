// SPDX-License-Identifier: Apache-2.0
#include "master/import/read_file.h"

namespace tessera::import {

Result<ReadScene> read_file(const std::string& path) {
  const auto format = check_content(path);
  if (!format.is_ok()) return format.status();
  switch (*format) {
#define TESSERA_FORMAT(enumerator, suffix, name, kind, place, begins, look, reader) \
  case FileFormat::enumerator:                                                      \
    return reader(path);
#include "common/scene_io/file_formats.inc"
  }
  return Status::unimplemented(path + ": no reader");
}

}  // namespace tessera::import
