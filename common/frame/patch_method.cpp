// SPDX-License-Identifier: Apache-2.0
#include "common/frame/patch_method.h"

#include "common/base/near_word.h"

namespace tessera {
namespace {

struct Row {
  std::string_view name, error;
};
constexpr Row kRows[] = {
    {"auto", "none"},
    {"refine", "up to 5e-5 of a patch's size for bicubic ones, with polygons as silhouettes"},
    {"newton", "up to 1e-6 of a patch's size; loses rays at silhouettes, folds and poles"},
    {"krawczyk", "up to 1e-6 of a patch's size; may lose rays in tangents"},
    {"clip", "up to 1e-6 of a patch's size; may lose rays in tangents"}};

const Row& row_of(PatchMethod method) { return kRows[static_cast<int>(method)]; }

}  // namespace

std::string_view patch_method_name(PatchMethod method) { return row_of(method).name; }
std::string_view patch_method_error(PatchMethod method) { return row_of(method).error; }

std::vector<std::string> patch_method_names() {
  std::vector<std::string> names;
  for (const Row& row : kRows) names.emplace_back(row.name);
  return names;
}

Result<PatchMethod> parse_patch_method(std::string_view text) {
  for (const PatchMethod method : kPatchMethods) {
    if (text == patch_method_name(method)) return method;
  }
  return Status::invalid_argument("--patch-method " + std::string(text) +
                                  ": give auto, refine, newton, krawczyk or clip" +
                                  did_you_mean(text, patch_method_names()));
}

std::string patch_method_help() {
  std::string text = "how rays meet patches: auto (exact), or, off by";
  for (const PatchMethod method : kPatchMethods) {
    if (method == PatchMethod::kAuto) continue;
    text += std::string(method == PatchMethod::kRefine ? " " : "; ") +
            std::string(patch_method_name(method)) + " (" +
            std::string(patch_method_error(method)) + ")";
  }
  return text;
}

std::string no_patches_line(PatchMethod method) {
  return "--patch-method " + std::string(patch_method_name(method)) +
         ": the scene has no patches, so it changes nothing";
}

}  // namespace tessera
