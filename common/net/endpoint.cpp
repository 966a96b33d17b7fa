// SPDX-License-Identifier: Apache-2.0
#include "common/net/endpoint.h"

#include <algorithm>
#include <charconv>

#include "common/net/io_thread_asio.h"

namespace tessera::net {

std::string Endpoint::text() const {
  const std::string shown = host.find(':') != std::string::npos ? "[" + host + "]" : host;
  return shown + ":" + std::to_string(port);
}

Result<Endpoint> parse_endpoint(const std::string& text) {
  const auto wrong = [&] {
    return Status::invalid_argument(text +
                                    ": give HOST:PORT, such as 127.0.0.1:7400 or [::1]:7400");
  };
  const auto colon = text.rfind(':');
  if (colon == std::string::npos) return wrong();
  Endpoint endpoint;
  endpoint.host = text.substr(0, colon);
  if (endpoint.host.size() >= 2 && endpoint.host.front() == '[' && endpoint.host.back() == ']') {
    endpoint.host = endpoint.host.substr(1, endpoint.host.size() - 2);
  } else if (endpoint.host.find(':') != std::string::npos) {
    return wrong();
  }
  if (endpoint.host.empty()) endpoint.host = "0.0.0.0";
  const char* const begin = text.data() + colon + 1;
  const char* const end = text.data() + text.size();
  const auto parsed = std::from_chars(begin, end, endpoint.port);
  if (parsed.ec != std::errc() || parsed.ptr != end) return wrong();
  return endpoint;
}

Result<std::vector<Endpoint>> parse_endpoints(const std::string& text) {
  std::vector<Endpoint> endpoints;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    auto endpoint = parse_endpoint(text.substr(begin, end - begin));
    if (!endpoint.is_ok()) return endpoint.status();
    endpoints.push_back(*endpoint);
    begin = end + 1;
  }
  return endpoints;
}

bool is_loopback(const Endpoint& endpoint) {
  asio::io_context context;
  asio::ip::tcp::resolver resolver(context);
  asio::error_code error;
  const auto results = resolver.resolve(endpoint.host, std::to_string(endpoint.port), error);
  if (error || results.empty()) return false;
  for (const auto& result : results) {
    if (!result.endpoint().address().is_loopback()) return false;
  }
  return true;
}

}  // namespace tessera::net
