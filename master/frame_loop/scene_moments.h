// SPDX-License-Identifier: Apache-2.0
// The scenes that slaves are told to build. Of a scene that does not move that is the scene as it
// was committed; of an animated one it is a scene for each time at which frames show it: the same
// blocks, another time. Slaves know each by a number of its own. Pure.
//
// Threads. One owner. Invariants. (1) Numbers rise. (2) Frames of the same scene and time have the
// same number, until that is retired. (3) Blocks are kept of the newest committed scene alone, and
// of those whose numbers are not retired.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "common/base/ids.h"
#include "common/scene/scene_codec.h"

namespace tessera::master {

class SceneMoments {
 public:
  using SharedScene = std::shared_ptr<const EncodedScene>;
  struct Moment {
    SceneVersion number = 0;
    SharedScene scene;  // to be sent; null: it was before
  };

  // A scene was committed; versions rise. It is shown at time 0 first.
  Moment commit(SceneVersion version, SharedScene scene);

  // The scene of a frame. Returns: nothing for a version that is not here.
  std::optional<Moment> at(SceneVersion version, double seconds);

  // The version that a number is of; 0 when it is retired.
  SceneVersion committed_as(SceneVersion number) const {
    const auto found = versions_.find(number);
    return found == versions_.end() ? 0 : found->second;
  }
  SceneVersion newest_number() const { return newest_number_; }

  // Numbers below are needed no more.
  void retire(SceneVersion first_kept);
  // Forgets all scenes; numbers go on.
  void clear();

 private:
  struct Committed {
    SharedScene scene;
    std::map<double, SceneVersion> numbers;  // by time
  };
  Moment show(SceneVersion version, Committed& committed, double seconds);

  std::map<SceneVersion, Committed> committed_;
  std::map<SceneVersion, SceneVersion> versions_;  // by number
  SceneVersion newest_number_ = 0;
};

}  // namespace tessera::master
