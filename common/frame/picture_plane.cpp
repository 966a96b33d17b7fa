// SPDX-License-Identifier: Apache-2.0
#include "common/frame/picture_plane.h"

#include <algorithm>
#include <vector>

#include "common/base/check.h"
#include "common/base/near_word.h"

namespace tessera {

static_assert(static_cast<std::size_t>(Plane::kSamples) + 1 == kPlaneRows.size());
static_assert(kPlaneRows.size() <= kPlanesMax);

namespace {

std::vector<std::string> names() {
  std::vector<std::string> all;
  PlaneSet::all().for_each([&](Plane plane) {
    if (plane_row(plane).option.empty()) all.emplace_back(plane_row(plane).name);
  });
  return all;
}

// Option of the command line that adds the planes; empty where none is needed.
std::string_view option_of(PlaneSet planes) {
  std::string_view option;
  planes.for_each([&](Plane plane) { option = plane_row(plane).option; });
  return option;
}

Status unknown(std::string_view name) {
  return Status::invalid_argument("--aov " + std::string(name) + ": give " + aov_names() +
                                  ", several with commas between" + did_you_mean(name, names()));
}

}  // namespace

std::size_t plane_count() { return kPlaneRows.size() + more_plane_rows().size(); }

const PlaneRow& plane_row(Plane plane) {
  const auto number = static_cast<std::size_t>(plane);
  if (number < kPlaneRows.size()) return kPlaneRows[number];
  TESSERA_CHECK_LT(number, plane_count());
  return more_plane_rows()[number - kPlaneRows.size()];
}

PlaneSet PlaneSet::all() {
  TESSERA_CHECK_LE(plane_count(), kPlanesMax);
  return of_bits(static_cast<std::uint32_t>((std::uint64_t{1} << plane_count()) - 1));
}

std::size_t channel_count(PlaneSet planes) {
  std::size_t count = 0;
  planes.for_each([&](Plane plane) { count += plane_row(plane).channel_count(); });
  return count;
}

Result<PlaneSet> parse_planes(std::string_view text) {
  PlaneSet asked;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view name = text.substr(begin, end - begin);
    PlaneSet named;
    PlaneSet::all().for_each([&](Plane plane) {
      if (plane_row(plane).name == name) named.add(plane);
    });
    if (named.is_empty()) return unknown(name);
    if (const std::string_view option = option_of(named); !option.empty())
      return Status::invalid_argument("--aov " + std::string(name) + ": give " +
                                      std::string(option) + ", which brings it");
    if ((asked.bits() & named.bits()) != 0)
      return Status::invalid_argument("--aov " + std::string(name) + ": it is named twice");
    asked = PlaneSet::of_bits(asked.bits() | named.bits());
    begin = end + 1;
  }
  return asked;
}

std::string aov_names() {
  std::string text;
  for (const std::string& name : names()) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace tessera
