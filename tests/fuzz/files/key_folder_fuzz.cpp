// SPDX-License-Identifier: Apache-2.0
// A folder of keys one of whose files is damaged, or is something else, is read or refused with a
// line; so is the ledger of a store. The good files are made anew in each process.
//
// The input: which file, how, and then its text, or changes of the DER inside: places of two bytes
// and what is added there.
#include <cstdlib>
#include <filesystem>

#include "common/net/key_folder.h"
#include "common/net/key_store.h"
#include "common/net/tls.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/temp_folder.h"

namespace {

using namespace tessera;

constexpr const char* kFiles[] = {"ca.crt", "node.crt", "node.key", "crl.pem"};

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// A store with a CA, a node "a" and a node "gone" that was revoked.
class Store {
 public:
  Store() {
    const bool is_made = net::init_key_store(folder_.path()).is_ok() &&
                         net::add_key(folder_.path(), "slave", "a", 30).is_ok() &&
                         net::add_key(folder_.path(), "slave", "gone", 30).is_ok() &&
                         net::revoke_key(folder_.path(), "gone").is_ok();
    if (!is_made) std::abort();
    for (const char* name : kFiles) good_.push_back(read_file(node() + "/" + name));
    ledger_ = read_file(folder_.path() + "/issued.txt");
  }
  std::string node() const { return folder_.path() + "/a"; }
  const std::string& path() const { return folder_.path(); }
  const std::string& good(std::size_t file) const { return good_[file]; }
  const std::string& ledger() const { return ledger_; }
  void put(const std::string& path, const std::string& text) const {
    std::ofstream(path, std::ios::binary) << text;
  }

 private:
  test::TempFolder folder_;
  std::vector<std::string> good_;
  std::string ledger_;
};

constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string decoded(const std::string& base64) {
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : base64) {
    const std::string_view digits(kDigits, 64);
    const auto digit = digits.find(c);
    if (digit == digits.npos) continue;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<char>(bits >> count & 0xff));
  }
  return bytes;
}

std::string encoded(const std::string& bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text.push_back(k <= bytes.size() - i ? kDigits[bits >> (18 - 6 * k) & 63] : '=');
    if (i / 3 % 16 == 15) text.push_back('\n');
  }
  return text + "\n";
}

// Returns: the PEM with some bytes of its DER changed.
std::string altered(const std::string& pem, test::FuzzInput& input) {
  const std::size_t head = pem.find('\n') + 1, tail = pem.rfind("-----END");
  std::string der = decoded(pem.substr(head, tail - head));
  while (!input.is_at_end() && !der.empty()) {
    char& byte = der[input.two_bytes() % der.size()];
    byte = static_cast<char>(byte + input.byte());
  }
  return pem.substr(0, head) + encoded(der) + pem.substr(tail);
}

template <class T>
void look_at(const Result<T>& result) {
  if (!result.is_ok() && result.status().message().empty()) std::abort();
}

// What a peer's certificate, or one in a folder, is asked for.
void look_into(const std::string& path) {
  if (const auto certificate = net::read_certificate(path)) {
    if (net::subject_text(certificate.get()).find('\n') != std::string::npos) std::abort();
    (void)net::serial_text(certificate.get());
    (void)net::last_day_text(certificate.get());
  }
  if (const auto list = net::read_revocation_list(path)) {
    (void)net::is_revoked(list.get(), "1");
    (void)net::number_of(list.get());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Store store;
  test::FuzzInput input(data, size);
  const std::uint8_t file = input.below(5);
  if (file == 4) {  // the ledger, from which a revocation reads
    const auto rest = input.rest();
    store.put(store.path() + "/issued.txt", {rest.begin(), rest.end()});
    const Status status = net::revoke_key(store.path(), "gone");
    if (!status.is_ok() && status.message().empty()) std::abort();
    store.put(store.path() + "/issued.txt", store.ledger());
    return 0;
  }
  const std::string path = store.node() + "/" + kFiles[file];
  const bool is_altered = input.yes();
  const std::string text = is_altered ? altered(store.good(file), input) : input.text(size);
  store.put(path, text);
  look_into(path);
  const auto folder = net::read_key_folder(store.node(), "slave");
  look_at(folder);
  // A pair that does not fit is tried again after a pause.
  if (folder.status().code() != StatusCode::kUnavailable)
    look_at(net::TlsContext::load(store.node(), "slave"));
  look_at(net::read_key_facts(store.path(), "a"));
  store.put(path, store.good(file));
  return 0;
}
