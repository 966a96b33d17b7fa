// SPDX-License-Identifier: Apache-2.0
#include "master/session/certificate_desk.h"

#include <ctime>
#include <utility>

#include "common/base/log.h"
#include "common/net/key_store.h"

namespace tessera::master {
namespace {

constexpr std::chrono::minutes kOwnLook{1};

}  // namespace

CertificateDesk::CertificateDesk(net::IoThread& io, std::string folder,
                                 std::shared_ptr<net::TlsContext> tls)
    : io_(io), folder_(std::move(folder)), tls_(std::move(tls)) {}

CertificateDesk::~CertificateDesk() { files_.stop(); }

void CertificateDesk::ask(const net::PeerIdentity& peer, std::vector<std::byte> request,
                          std::function<void(wire::CertificateGrant)> answer) {
  if (std::string why = rule_.refusal_of(peer, std::time(nullptr), Clock::now()); !why.empty()) {
    log_warn("certificate-refused", "'" + peer.name + "' gets no certificate: " + why);
    return answer({{}, std::move(why)});
  }
  files_.post([this, role = peer.role, name = peer.name, request = std::move(request),
               answer = std::move(answer)] {
    auto made = net::certify_key(folder_, role, name, request, net::kNodeDays);
    io_.post([role, name, answer, made = std::move(made)]() mutable {
      if (!made.is_ok()) {
        log_warn("certificate-refused",
                 "'" + name + "' gets no certificate: " + made.status().message());
        // What the authority's folder is called is nothing that a peer must know.
        return answer({{}, "the master could not make it; its log says why"});
      }
      log_info("certificate-issued", role + " '" + name + "' got a new certificate");
      answer({std::move(*made), ""});
    });
  });
}

void CertificateDesk::start() {
  timer_ = std::make_unique<net::Timer>(io_);
  timer_->start_repeating(kOwnLook, [this] { look_at_own(); });
  look_at_own();
}

void CertificateDesk::close() { timer_.reset(); }

void CertificateDesk::look_at_own() {
  const TimePoint now = Clock::now();
  if (now < own_next_ || !net::is_renewal_due(tls_->life(), std::time(nullptr))) return;
  own_next_ = now + IssueRule::kPause;
  files_.post([folder = folder_, keys = tls_->folder(), name = tls_->name()] {
    const net::KeyRequest request;
    const auto made = net::certify_key(folder, "master", name, request.der(), net::kNodeDays);
    const Status status = made.is_ok() ? request.take_over(keys, *made) : made.status();
    if (status.is_ok()) return log_info("certificate-renewed", "a new one is in " + keys);
    log_warn("certificate-kept", "the master's own could not be renewed: " + status.message());
  });
}

}  // namespace tessera::master
