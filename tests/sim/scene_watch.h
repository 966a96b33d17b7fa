// SPDX-License-Identifier: Apache-2.0
// What slaves have of scenes, by the words on the wire: what must hold however chunks come, from
// the master or from slave to slave.
//
//   I3  a scene that is built has the announced digests, and the bytes that they stand for
//   I6  a slave that works gets each scene that was announced to it, within a bound
//   I7  who is said to alter chunks does alter them; slaves send each other away for no other
//       reason than a race
//
// Threads. The simulation's one.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/scene/scene_codec.h"
#include "common/wire/announced_blocks.h"
#include "common/wire/messages.h"

namespace tessera::sim {

class SceneWatch {
 public:
  using Report = std::function<void(const std::string&)>;

  SceneWatch(std::size_t slaves, Report report) : slaves_(slaves), report_(std::move(report)) {}
  // How long a slave that works may wait for a scene.
  void set_wait_max(double wait_max_s) { wait_max_s_ = wait_max_s; }

  void on_said_to(std::size_t slave, const net::Record& record, double now);
  void on_said_by(std::size_t slave, const net::Record& record);
  void on_said_between(std::size_t slave, const net::Record& record);
  // A whole scene is at a slave, which begins to build it.
  void on_scene(std::size_t slave, SceneVersion version, const EncodedScene& scene);
  void on_altering(std::size_t slave) { slaves_[slave].has_altered = true; }
  // is_excused: what was done to the slave accounts for a wait.
  void check(std::size_t slave, bool is_listed, bool is_excused, double now);
  bool is_any_awaited() const;  // by a slave that the master lists
  std::uint64_t chunks_relayed() const { return chunks_relayed_; }

 private:
  struct Slave {
    std::map<SceneVersion, wire::BlockNames> announced;  // of this session, not retired
    wire::AnnouncedBlocks newest_blocks;
    std::map<SceneVersion, double> lacking;  // since when; neither built nor failed
    bool has_altered = false, is_listed = false;
  };
  static std::string name_of(std::size_t slave) { return "s" + std::to_string(slave); }

  std::vector<Slave> slaves_;
  std::map<SessionId, std::size_t> sessions_;
  double wait_max_s_ = 0;
  std::uint64_t chunks_relayed_ = 0;
  const Report report_;
};

}  // namespace tessera::sim
