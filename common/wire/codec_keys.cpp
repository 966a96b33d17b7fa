// SPDX-License-Identifier: Apache-2.0
// Codec of the messages by which a certificate is renewed.
#include "common/wire/codec_internal.h"
#include "proto/envelope.pb.h"

namespace tessera::wire {

net::Record encode_one(CertificateRequest m) {
  proto::CertificateRequest h;
  h.set_der_bytes(static_cast<std::uint32_t>(m.der.size()));
  return make_record(RecordType::kCertificateRequest, h, net::SharedBytes::of(std::move(m.der)));
}

Result<Message> decode_certificate_request(net::ReceivedRecord record) {
  proto::CertificateRequest h;
  if (!parse_header(record, h)) return bad_header("CertificateRequest");
  FieldCheck check("CertificateRequest");
  check.range("der_bytes", h.der_bytes(), 1, kCertificateBytesMax);
  check.payload_bytes(record.payload.size(), h.der_bytes());
  if (!check.is_ok()) return check.status();
  return Message(CertificateRequest{std::move(record.payload)});
}

net::Record encode_one(CertificateGrant m) {
  proto::CertificateGrant h;
  h.set_reason(clean_line(std::move(m.reason)));
  h.set_der_bytes(static_cast<std::uint32_t>(m.der.size()));
  return make_record(RecordType::kCertificateGrant, h, net::SharedBytes::of(std::move(m.der)));
}

Result<Message> decode_certificate_grant(net::ReceivedRecord record) {
  proto::CertificateGrant h;
  if (!parse_header(record, h)) return bad_header("CertificateGrant");
  FieldCheck check("CertificateGrant");
  check.line("reason", h.reason());
  const bool is_granted = h.reason().empty();
  check.range("der_bytes", h.der_bytes(), is_granted ? 1 : 0,
              is_granted ? kCertificateBytesMax : 0);
  check.payload_bytes(record.payload.size(), h.der_bytes());
  if (!check.is_ok()) return check.status();
  return Message(CertificateGrant{std::move(record.payload), std::move(*h.mutable_reason())});
}

}  // namespace tessera::wire
