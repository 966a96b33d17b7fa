// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/reception.h"

#include <gtest/gtest.h>

#include "common/base/limits.h"

namespace tessera::master {
namespace {

net::PeerIdentity certificate(std::string role, std::string name) {
  net::PeerIdentity peer;
  peer.is_authenticated = true;
  peer.role = std::move(role);
  peer.name = std::move(name);
  return peer;
}

wire::Hello hello_of(std::string name) {
  wire::Hello hello;
  hello.name = std::move(name);
  return hello;
}

TEST(Reception, WithKeysANameIsTheCertificates) {
  EXPECT_EQ(name_in_force(certificate("slave", "bert"), hello_of("anna")), "bert");
  EXPECT_EQ(name_in_force(certificate("slave", "bert"), hello_of("bert")), "bert");
  EXPECT_EQ(name_in_force({}, hello_of("anna")), "anna") << "loopback without keys";
  EXPECT_EQ(name_in_force(certificate("slave", ""), hello_of("anna")), "")
      << "no certificate gives a name by saying none";
  const std::string is_long(200, 'x');
  EXPECT_EQ(name_in_force(certificate("slave", is_long), hello_of("anna")).size(), kNameBytesMax);
}

}  // namespace
}  // namespace tessera::master
