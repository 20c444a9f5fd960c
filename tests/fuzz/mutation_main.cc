// Calls a fuzz target with its seeds and with random changes of them; no
// coverage guides it, but every compiler can build it.
//   fuzz_X [--runs N] [--seed S] [FILE ...]    files are tried as they are
//   fuzz_X --write_seeds FOLDER

#include "tests/fuzz/fuzz_target.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace structnerf {
namespace {

class Mutator {
 public:
  Mutator(std::vector<std::string> seeds, const unsigned seed)
      : seeds_(std::move(seeds)), random_(seed) {}

  std::string Next() {
    std::string input = seeds_[Below(seeds_.size())];
    for (size_t num_changes = 1 + Below(6); num_changes > 0; --num_changes) {
      Change(&input);
    }
    return input;
  }

 private:
  size_t Below(const size_t end) { return random_() % end; }

  void Change(std::string* input) {
    if (input->empty()) {
      input->push_back(static_cast<char>(Below(256)));
      return;
    }
    const size_t place = Below(input->size());
    switch (Below(8)) {
      case 0:
        (*input)[place] ^= static_cast<char>(1 << Below(8));
        break;
      case 1:
        (*input)[place] = static_cast<char>(Below(256));
        break;
      case 2:
        input->resize(place);
        break;
      case 3:
        input->erase(place, 1 + Below(16));
        break;
      case 4:
        input->insert(place, 1 + Below(16), static_cast<char>(Below(256)));
        break;
      case 5:
        input->insert(place, kTokens[Below(std::size(kTokens))]);
        break;
      case 6: {  // overwrite by a number of four bytes
        const uint32_t number = kNumbers[Below(std::size(kNumbers))];
        for (size_t i = 0; i < 4 && place + i < input->size(); ++i) {
          (*input)[place + i] = static_cast<char>(number >> (8 * i));
        }
        break;
      }
      default: {  // the rest of another seed
        const std::string& other = seeds_[Below(seeds_.size())];
        const size_t begin = Below(other.size() + 1);
        input->replace(place, std::string::npos, other.substr(begin));
      }
    }
  }

  static constexpr const char* kTokens[] = {"-1",
                                            "0",
                                            "2147483647",
                                            "4294967296",
                                            "99999999999999999999",
                                            "nan",
                                            "inf",
                                            "=",
                                            "--",
                                            "&",
                                            "\n",
                                            "[",
                                            "]",
                                            "../",
                                            "%s",
                                            "\"",
                                            "1e999"};
  static constexpr uint32_t kNumbers[] = {0,
                                          1,
                                          0x7f,
                                          0xff,
                                          0x7fff,
                                          0xffff,
                                          0x7fffffff,
                                          0x80000000,
                                          0xffffffff,
                                          0x7fc00000,
                                          0x7f800000};

  std::vector<std::string> seeds_;
  std::mt19937 random_;
};

void Try(const std::string& input) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(input.data()),
                         input.size());
}

int Run(const std::vector<std::string>& arguments) {
  long num_runs = 0;
  unsigned seed = 1;
  const std::vector<std::string> seeds = FuzzSeeds();
  for (size_t i = 0; i < arguments.size(); ++i) {
    const bool has_value = i + 1 < arguments.size();
    if (arguments[i] == "--runs" && has_value) {
      num_runs = std::atol(arguments[++i].c_str());
    } else if (arguments[i] == "--seed" && has_value) {
      seed = static_cast<unsigned>(std::atol(arguments[++i].c_str()));
    } else if (arguments[i] == "--write_seeds" && has_value) {
      const std::filesystem::path folder = arguments[++i];
      std::filesystem::create_directories(folder);
      for (size_t k = 0; k < seeds.size(); ++k) {
        WriteFuzzFile((folder / std::to_string(k)).string(),
                      reinterpret_cast<const uint8_t*>(seeds[k].data()),
                      seeds[k].size());
      }
      return EXIT_SUCCESS;
    } else {
      Try(ReadFuzzFile(arguments[i]));
    }
  }
  for (const std::string& input : seeds) {
    Try(input);
  }
  Mutator mutator(seeds, seed);
  for (long run = 0; run < num_runs; ++run) {
    Try(mutator.Next());
  }
  std::printf(
      "%zu seeds and %ld changes of them, no fault\n", seeds.size(), num_runs);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace structnerf

int main(int argc, char** argv) {
  return structnerf::Run({argv + 1, argv + argc});
}
