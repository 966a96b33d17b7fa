// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/scene_watch.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include "common/wire/codec.h"
#include "common/wire/record_types.h"
#include "tests/sim/picture.h"

namespace tessera::sim {
namespace {

// Decodes records of this kind alone, since there are many others.
template <typename M>
std::optional<M> as(wire::RecordType type, const net::Record& record) {
  if (record.type != static_cast<std::uint16_t>(type)) return std::nullopt;
  const auto& bytes = record.payload.bytes;
  auto message = wire::decode({record.type, record.header, {bytes.begin(), bytes.end()}});
  return message.is_ok() ? std::optional(std::get<M>(std::move(*message))) : std::nullopt;
}

// As operator==, which compares std::byte one by one.
bool has_same_bytes(std::span<const std::byte> a, std::span<const std::byte> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace

void SceneWatch::on_said_to(std::size_t slave, const net::Record& record, double now) {
  using Type = wire::RecordType;
  Slave& it = slaves_[slave];
  if (const auto welcome = as<wire::Welcome>(Type::kWelcome, record)) {
    sessions_[welcome->session] = slave;
    it.announced.clear();
    it.lacking.clear();
  } else if (const auto announce = as<wire::SceneAnnounce>(Type::kSceneAnnounce, record)) {
    if (!it.newest_blocks.take(*announce).is_ok()) return;
    it.announced[announce->version] = it.newest_blocks.names();
    it.lacking[announce->version] = now;
  } else if (const auto retire = as<wire::SceneRetire>(Type::kSceneRetire, record)) {
    it.announced.erase(it.announced.begin(), it.announced.lower_bound(retire->first_kept));
    it.lacking.erase(it.lacking.begin(), it.lacking.lower_bound(retire->first_kept));
  }
}

void SceneWatch::on_said_by(std::size_t slave, const net::Record& record) {
  using Type = wire::RecordType;
  if (const auto built = as<wire::SceneBuilt>(Type::kSceneBuilt, record)) {
    slaves_[slave].lacking.erase(built->version);
  } else if (const auto failed = as<wire::SceneFailed>(Type::kSceneFailed, record)) {
    slaves_[slave].lacking.erase(failed->version);
  } else if (const auto fault = as<wire::RelayFailed>(Type::kRelayFailed, record)) {
    const auto feeder = sessions_.find(fault->feeder);
    if (fault->fault != wire::RelayFault::kAltered || feeder == sessions_.end()) return;
    if (slaves_[feeder->second].has_altered) return;
    report_("I7: " + name_of(slave) + " says that " + name_of(feeder->second) +
            " alters chunks, which it does not: " + fault->reason);
  }
}

// A child may ask for a version that is retired meanwhile, or say the token of a feeder that began
// anew. Nothing else is a reason.
void SceneWatch::on_said_between(std::size_t slave, const net::Record& record) {
  const auto chunk = static_cast<std::uint16_t>(wire::RecordType::kSceneChunk);
  if (record.type == chunk) ++chunks_relayed_;
  const auto refuse = as<wire::Refuse>(wire::RecordType::kRefuse, record);
  if (!refuse) return;
  const bool is_race =
      refuse->reason == "a wrong token" || refuse->reason.ends_with(" is not here");
  if (!is_race) report_("I7: " + name_of(slave) + " sends a child away: " + refuse->reason);
}

void SceneWatch::on_scene(std::size_t slave, SceneVersion version, const EncodedScene& scene) {
  const auto announced = slaves_[slave].announced.find(version);
  if (announced == slaves_[slave].announced.end()) return;  // retired meanwhile
  const wire::BlockNames& names = announced->second;
  bool is_right = scene.blocks.size() == names.size();
  for (std::size_t i = 0; is_right && i < names.size(); ++i) {
    const std::span<const std::byte>* const bytes = bytes_of(names[i].digest);
    is_right = scene.blocks[i].digest == names[i].digest && bytes != nullptr &&
               has_same_bytes(*scene.blocks[i].bytes, *bytes);
  }
  if (is_right) return;
  report_("I3: " + name_of(slave) + " builds version " + std::to_string(version) +
          " from other bytes than were announced");
}

bool SceneWatch::is_any_awaited() const {
  return std::any_of(slaves_.begin(), slaves_.end(),
                     [](const Slave& slave) { return slave.is_listed && !slave.lacking.empty(); });
}

void SceneWatch::check(std::size_t slave, bool is_listed, bool is_excused, double now) {
  slaves_[slave].is_listed = is_listed;
  for (auto& [version, since] : slaves_[slave].lacking) {
    if (!is_listed || is_excused) since = now;
    if (now - since <= wait_max_s_) continue;
    report_("I6: " + name_of(slave) + " has waited for scene version " + std::to_string(version) +
            " for " + std::to_string(now - since) + " s, bound " + std::to_string(wait_max_s_));
  }
}

}  // namespace tessera::sim
