// SPDX-License-Identifier: Apache-2.0
// Runs a fuzz target without libFuzzer: every file of the corpus, then mutations of them from a
// seed, so that a failure can be replayed anywhere.
//
// Usage: TARGET CORPUS [--runs N] [--seed S] [--only RUN]
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
extern "C" __attribute__((weak)) void __sanitizer_set_death_callback(void (*callback)());

namespace {

using Input = std::vector<std::uint8_t>;

constexpr std::size_t kInputBytesMax = 64 * 1024;
volatile long current_run = -1;
std::uint64_t seed = 1;

void tell_run() {
  char text[96];
  const int size =
      std::snprintf(text, sizeof(text), "fuzz: failed; replay: --seed %llu --only %ld\n",
                    static_cast<unsigned long long>(seed), current_run);
  if (::write(STDERR_FILENO, text, static_cast<std::size_t>(size)) < 0) return;
}

void on_signal(int number) {
  tell_run();
  signal(number, SIG_DFL);
  raise(number);
}

std::vector<Input> read_corpus(const std::string& folder) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file()) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Input> corpus;
  for (const auto& path : paths) {
    std::ifstream file(path, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return corpus;
}

class Mutator {
 public:
  Mutator(const std::vector<Input>& corpus, std::uint64_t run)
      : corpus_(corpus), random_(seed * 0x9e3779b97f4a7c15u + run) {}

  Input make() {
    Input input = corpus_[below(corpus_.size())];
    for (std::size_t i = 1 + below(5); i > 0; --i) mutate(input);
    if (input.size() > kInputBytesMax) input.resize(kInputBytesMax);
    return input;
  }

 private:
  std::size_t below(std::size_t count) { return count == 0 ? 0 : random_() % count; }

  void mutate(Input& input) {
    switch (below(8)) {
      case 0:  // one bit
        if (!input.empty()) input[below(input.size())] ^= static_cast<std::uint8_t>(1u << below(8));
        break;
      case 1:  // one byte
        if (!input.empty()) input[below(input.size())] = static_cast<std::uint8_t>(random_());
        break;
      case 2:
        put_number(input);
        break;
      case 3:
        input.resize(below(input.size() + 1));
        break;
      case 4: {  // removes a piece
        const std::size_t begin = below(input.size()), count = below(input.size() - begin + 1);
        input.erase(input.begin() + static_cast<std::ptrdiff_t>(begin),
                    input.begin() + static_cast<std::ptrdiff_t>(begin + count));
        break;
      }
      case 5:
        insert(input, input);
        break;
      case 6:
        insert(input, corpus_[below(corpus_.size())]);
        break;
      default: {  // digits, where text is read
        static const char* const kWords[] = {"-1",  "0",  "4294967296",          "1e39",
                                             "nan", "-0", "99999999999999999999"};
        const char* const word = kWords[below(std::size(kWords))];
        insert(input, Input(word, word + std::strlen(word)));
      }
    }
  }

  // Overwrites 1, 2, 4 or 8 bytes with a number on the edge of its type.
  void put_number(Input& input) {
    static constexpr std::uint64_t kNumbers[] = {0,          1,          0x7f,       0x80,
                                                 0xff,       0x7fff,     0xffff,     0x7fffffff,
                                                 0x80000000, 0xffffffff, 1ull << 32, ~0ull};
    const std::size_t size = std::size_t{1} << below(4);
    if (input.size() < size) return;
    const std::uint64_t number = kNumbers[below(std::size(kNumbers))];
    std::memcpy(input.data() + below(input.size() - size + 1), &number, size);
  }

  void insert(Input& input, const Input& source) {
    const std::size_t begin = below(source.size()), count = below(source.size() - begin + 1);
    const Input piece(source.begin() + static_cast<std::ptrdiff_t>(begin),
                      source.begin() + static_cast<std::ptrdiff_t>(begin + count));
    input.insert(input.begin() + static_cast<std::ptrdiff_t>(below(input.size() + 1)),
                 piece.begin(), piece.end());
  }

  const std::vector<Input>& corpus_;
  std::mt19937_64 random_;
};

void run_one(const Input& input) {
  // An exact copy on the heap, so that a read behind the end is seen.
  const Input exact(input);
  LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

}  // namespace

int main(int argc, char** argv) {
  std::string folder;
  long runs = 20000, only = -1;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const char* const value = i + 1 < argc ? argv[i + 1] : "0";
    if (word == "--runs") {
      runs = std::atol(value), ++i;
    } else if (word == "--seed") {
      seed = std::strtoull(value, nullptr, 10), ++i;
    } else if (word == "--only") {
      only = std::atol(value), ++i;
    } else {
      folder = word;
    }
  }
  std::vector<Input> corpus = read_corpus(folder);
  if (corpus.empty()) {
    std::fprintf(stderr, "fuzz: no corpus in '%s'\n", folder.c_str());
    return 2;
  }
  for (const int number : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS}) signal(number, on_signal);
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(tell_run);
  if (only < 0) {
    for (const Input& input : corpus) run_one(input);
  }
  for (long run = std::max(only, 0L); run < (only < 0 ? runs : only + 1); ++run) {
    current_run = run;
    run_one(Mutator(corpus, static_cast<std::uint64_t>(run)).make());
  }
  std::printf("fuzz: %zu inputs of the corpus and %ld mutations from seed %llu\n", corpus.size(),
              only < 0 ? runs : 1L, static_cast<unsigned long long>(seed));
  return 0;
}
