#include "master/cluster/reception.h"

#include <algorithm>
#include <utility>

#include "common/base/log.h"
#include "common/wire/codec.h"

namespace tessera::master {

std::uint16_t common_version(std::uint16_t version_min, std::uint16_t version_max) {
  const std::uint16_t version = std::min(version_max, wire::kProtocolVersionMax);
  return version >= std::max(version_min, wire::kProtocolVersionMin) ? version : std::uint16_t{0};
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
  guests_.push_back({nullptr, listener});
  const GuestIterator guest = std::prev(guests_.end());
  PeerLink::Callbacks callbacks;
  callbacks.on_message = [this, guest](wire::Message message) {
    on_first_message(guest, std::move(message));
  };
  callbacks.on_ended = [this, guest](const Status& status) {
    log_warn("peer-left-early", "a peer left before it said who it is: " + status.message(),
             {{"peer", guest->link->peer_text()}});
    guests_.erase(guest);
  };
  guest->link = std::make_unique<PeerLink>(io_, std::move(connection), wire::pre_auth_limits(),
                                           std::move(callbacks));
}

void Reception::turn_away(GuestIterator guest, wire::RefuseCode code, const std::string& reason) {
  log_warn("peer-refused", reason, {{"peer", guest->link->peer_text()}});
  guest->link->refuse(code, reason);
  guests_.erase(guest);
}

void Reception::on_first_message(GuestIterator guest, wire::Message message) {
  net::Connection& connection = guest->link->connection();
  if (auto* hello = std::get_if<wire::Hello>(&message)) {
    const std::uint16_t version = common_version(hello->version_min, hello->version_max);
    if (version == 0) {
      return turn_away(
          guest, wire::RefuseCode::kVersion,
          "'" + hello->name + "' speaks protocol versions " + std::to_string(hello->version_min) +
              " to " + std::to_string(hello->version_max) + ", this master " +
              std::to_string(wire::kProtocolVersionMin) + " to " +
              std::to_string(wire::kProtocolVersionMax) + "; install the same build on both");
    }
    if (!may_act_as(connection.peer(), hello->role)) {
      return turn_away(guest, wire::RefuseCode::kRole,
                       "a certificate of role '" + connection.peer().role + "' (" +
                           connection.peer().name +
                           ") may not do this; make the right one with 'tessera-keys add'");
    }
    if (guest->listener != nullptr) guest->listener->mark_authenticated(connection);
    auto link = std::move(guest->link);
    guests_.erase(guest);
    link->set_limits(wire::session_limits());
    return callbacks_.on_hello(std::move(link), std::move(*hello), version);
  }
  if (auto* join = std::get_if<wire::Join>(&message)) {
    if (!may_act_as(connection.peer(), wire::Role::kSlave)) {
      return turn_away(guest, wire::RefuseCode::kRole, "only a slave may join a session");
    }
    if (guest->listener != nullptr) guest->listener->mark_authenticated(connection);
    auto link = std::move(guest->link);
    guests_.erase(guest);
    link->set_limits(wire::session_limits());
    return callbacks_.on_join(std::move(link), *join);
  }
  turn_away(guest, wire::RefuseCode::kProtocol,
            std::string(wire::message_name(message)) + " before Hello");
}

}  // namespace tessera::master
