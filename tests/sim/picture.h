// SPDX-License-Identifier: Apache-2.0
// The scenes and pictures of the simulated world. A scene carries a tag (in the position of a
// vertex); a pixel is a function of (tag, time, frame settings, position). So a picture shows which
// scene it was rendered from, and of which time one that moves, and any mix-up of versions, times,
// frames or tiles shows as a wrong byte. Scenes that differ by edits (edited_scenes.h) are built by
// the product's core, and what rays meet of them stands for the tag.
//
// Threads. The simulation's one (scenes are made once for each process and tag).
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <span>

#include "common/frame/frame_settings.h"
#include "common/frame/tile_grid.h"
#include "common/scene/scene_codec.h"
#include "slave/core/scene/prepared_scene.h"

namespace tessera::sim {

inline constexpr int kSceneTagsMax = 64;

enum class SceneWeight {
  kLight,     // two meshes
  kHeavy,     // and a texture of 3 MiB that all tags share
  kChanging,  // and one of 1.13 MiB, of which a tag has two chunks of its own
  kMoving,    // two meshes, of which one moves with the frame's time
  kEdited,    // those of edited_scenes.h
};

// Frames show scenes that move at one of these times.
inline constexpr int kTimes = 4;
constexpr double time_of(int index) { return 0.25 * index; }

// Blocks of the scene with this tag: a mesh that all share, one of its own, and what the weight
// says. Requires: 0 <= tag < kSceneTagsMax.
const EncodedScene& scene_of_tag(int tag, SceneWeight weight);

// Bytes of the block with this digest in any scene of these; null where it is in none.
const std::span<const std::byte>* bytes_of(const Digest& digest);

// What of a scene a picture shows: its tag, and its time where it moves, or what rays meet of it.
struct Shown {
  int tag = 0;
  double seconds = 0;
  std::uint64_t met = 0;
  auto operator<=>(const Shown&) const = default;
};

// What a picture of the scene with this tag shows, of weight kEdited.
Shown shown_of_edited(int tag);

// Decodes blocks that came over the network, of another weight than kEdited. Returns: what they
// show, or the decoder's refusal.
Result<Shown> shown_by(const EncodedScene& scene);

// A prepared scene that stands for what is shown, and back; one that was built says what rays meet.
std::shared_ptr<const core::PreparedScene> prepared_for(const Shown& shown);
Shown shown_by(const core::PreparedScene& scene);

// Writes the pixels of `rect`. Requires: kDisplay8, bytes.size() == 3 * rect.pixel_count().
void draw(const Shown& shown, const FrameSettings& settings, const TileRect& rect,
          std::span<std::byte> bytes);

}  // namespace tessera::sim
