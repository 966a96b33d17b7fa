// SPDX-License-Identifier: Apache-2.0
// One page of text at one path, over HTTP/1.0, for scrapers; a browser or curl may read it, too.
// Everything else of HTTP is refused: other methods get 405, other paths 404, and a connection
// whose request is too long or too slow is closed.
//
// Threads. Io thread only; the page is written there, too, when somebody asks.
//
// Invariants. (1) Loopback only: nothing listens beyond it without keys, and this page has none.
// (2) At most kConnectionsMax connections are open at once, each with kRequestBytesMax and
// kDeadline. For a further one the oldest that has not asked yet is closed. (3) Who asks for a host
// that is not loopback gets 403: a page of the web that leads a browser here by a name of its own.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/net/endpoint.h"
#include "common/net/io_thread.h"

namespace tessera::net {

class HttpPage {
 public:
  static constexpr std::size_t kConnectionsMax = 8;
  static constexpr std::size_t kRequestBytesMax = 4096;
  static constexpr std::chrono::milliseconds kDeadline{5000};  // of a whole exchange

  struct Content {
    std::string path;  // "/metrics"
    std::string type;
    std::function<std::string()> write;
  };

  // Listens until destroyed. Returns: kInvalidArgument for an address beyond loopback, kUnavailable
  // naming address and reason (port in use).
  static Result<std::unique_ptr<HttpPage>> open(IoThread& io, const Endpoint& endpoint,
                                                Content content);
  virtual ~HttpPage() = default;
  virtual std::uint16_t port() const = 0;  // the one chosen when asked for 0
};

}  // namespace tessera::net
