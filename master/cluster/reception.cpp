// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/reception.h"

#include <algorithm>
#include <utility>

#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/wire/codec.h"

namespace tessera::master {

std::uint16_t common_version(std::uint16_t version_min, std::uint16_t version_max) {
  const std::uint16_t version = std::min(version_max, wire::kProtocolVersionMax);
  return version >= std::max(version_min, wire::kProtocolVersionMin) ? version : std::uint16_t{0};
}

std::string name_in_force(const net::PeerIdentity& peer, const wire::Hello& hello) {
  return peer.is_authenticated ? peer.name.substr(0, kNameBytesMax) : hello.name;
}

bool may_act_as(const net::PeerIdentity& peer, wire::Role role) {
  if (!peer.is_authenticated) return true;
  switch (role) {
    case wire::Role::kSlave:
      return peer.role == "slave";
    case wire::Role::kApp:
      return peer.role == "app";
    case wire::Role::kStatus:
      return peer.role == "app" || peer.role == "master";
  }
  return false;
}

void Reception::receive(net::ConnectionPtr connection, net::Listener* listener) {
  const GuestNumber number = next_guest_++;
  PeerLink::Callbacks callbacks;
  callbacks.on_message = [this, number](wire::Message message) {
    on_first_message(number, std::move(message));
  };
  callbacks.on_ended = [this, number](const Status& status) { on_left(number, status); };
  auto link = std::make_unique<PeerLink>(io_, std::move(connection), wire::pre_auth_limits(),
                                         std::move(callbacks));
  guests_.emplace(number, Guest{std::move(link), listener});
}

void Reception::on_left(GuestNumber number, const Status& status) {
  const auto guest = guests_.find(number);
  if (guest == guests_.end()) return;
  log_warn("peer-left-early", "a peer left before it said who it is: " + status.message(),
           {{"peer", guest->second.link->peer_text()}});
  guests_.erase(guest);
}

void Reception::turn_away(GuestNumber number, wire::RefuseCode code, const std::string& reason) {
  PeerLink& link = *guests_.at(number).link;
  log_warn("peer-refused", reason, {{"peer", link.peer_text()}});
  link.refuse(code, reason);
  guests_.erase(number);
}

std::unique_ptr<PeerLink> Reception::let_in(GuestNumber number) {
  Guest guest = std::move(guests_.at(number));
  guests_.erase(number);
  if (guest.listener != nullptr) guest.listener->mark_authenticated(guest.link->connection());
  guest.link->set_limits(wire::session_limits());
  return std::move(guest.link);
}

void Reception::on_first_message(GuestNumber number, wire::Message message) {
  const auto guest = guests_.find(number);
  if (guest == guests_.end()) return;
  const net::PeerIdentity& peer = guest->second.link->connection().peer();
  if (auto* hello = std::get_if<wire::Hello>(&message)) {
    const std::uint16_t version = common_version(hello->version_min, hello->version_max);
    if (version == 0) {
      return turn_away(
          number, wire::RefuseCode::kVersion,
          "'" + hello->name + "' speaks protocol versions " + std::to_string(hello->version_min) +
              " to " + std::to_string(hello->version_max) + ", this master " +
              std::to_string(wire::kProtocolVersionMin) + " to " +
              std::to_string(wire::kProtocolVersionMax) + "; install the same build on both");
    }
    if (!may_act_as(peer, hello->role)) {
      return turn_away(number, wire::RefuseCode::kRole,
                       "a certificate of role '" + peer.role + "' (" + peer.name +
                           ") may not do this; make the right one with 'tessera-keys add'");
    }
    if (hello->role == wire::Role::kSlave && name_in_force(peer, *hello).empty()) {
      return turn_away(number, wire::RefuseCode::kRole,
                       "the certificate has no name; make one with 'tessera-keys add'");
    }
    // A slave that is let in needs a second descriptor; who asks for the status one for a moment.
    if (peer.is_in_reserve && hello->role != wire::Role::kStatus) {
      return turn_away(number, wire::RefuseCode::kFull,
                       "the master has no connections left: raise its limit of open files");
    }
    return callbacks_.on_hello(let_in(number), std::move(*hello), version);
  }
  if (auto* join = std::get_if<wire::Join>(&message)) {
    if (!may_act_as(peer, wire::Role::kSlave)) {
      return turn_away(number, wire::RefuseCode::kRole, "only a slave may join a session");
    }
    return callbacks_.on_join(let_in(number), *join);
  }
  turn_away(number, wire::RefuseCode::kProtocol,
            std::string(wire::message_name(message)) + " before Hello");
}

}  // namespace tessera::master
