// Every reader with its whole corpus, and with seeded mutations of it: what a fuzzer of a few seconds finds, the same on every machine.
#include "readers.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "sgraph_slam/core/util/rng.hpp"

namespace sgraph::fuzz {
namespace {

using Corpus = std::vector<std::string>;

Corpus corpus_of(const std::string& reader) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator("test/fuzz/corpus/" + reader)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  Corpus corpus;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return corpus;
}

/// Changes that break readers: bits, numbers at the ends of their ranges, pieces left out, repeated, or taken from elsewhere.
class Mutator {
 public:
  Mutator(const Corpus& corpus, std::uint64_t seed) : corpus_(corpus), random_(seed, 1) {}

  std::string next() {
    std::string text = corpus_[below(corpus_.size())];
    const std::size_t changes = 1 + below(4);
    for (std::size_t i = 0; i < changes; ++i) change(text);
    return text;
  }

 private:
  std::size_t below(std::size_t end) { return end == 0 ? 0 : static_cast<std::size_t>(random_.next_uniform() * static_cast<double>(end)); }

  void change(std::string& text) {
    const std::size_t at = below(text.size());
    const std::size_t length = std::min(text.size() - at, 1 + below(32));
    switch (below(6)) {
      case 0:
        if (!text.empty()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        break;
      case 1: text.erase(at, length); break;
      case 2: text.insert(at, text.substr(at, length)); break;
      case 3: text.resize(at); break;
      case 4: replace_number(text, at); break;
      default: {
        const std::string& other = corpus_[below(corpus_.size())];
        text.replace(at, length, other.substr(below(other.size()), length));
      }
    }
  }

  void replace_number(std::string& text, std::size_t from) {
    static constexpr std::array<const char*, 12> numbers{"0",      "-1",  "1e309", "nan", "-inf", "4294967296", "9223372036854775808",
                                                         "1e-320", "0.1", "\"\"",  "[]",  "null"};
    static constexpr const char* digits = "+-.0123456789eE";
    const std::size_t begin = text.find_first_of("0123456789", from);
    if (begin == std::string::npos) return;
    const std::size_t end = std::min(text.find_first_not_of(digits, begin), text.size());
    text.replace(begin, end - begin, numbers[below(numbers.size())]);
  }

  const Corpus& corpus_;
  RandomStream random_;
};

class Readers : public testing::TestWithParam<std::string> {};

TEST_P(Readers, TakeOrRefuseWhateverComes) {
  const Corpus corpus = corpus_of(GetParam());
  ASSERT_FALSE(corpus.empty());
  const Reader& reader = readers().at(GetParam());
  for (const std::string& text : corpus) ASSERT_NO_THROW(reader(text)) << text;
  Mutator mutator(corpus, 20);
  for (int i = 0; i < 500; ++i) {
    const std::string text = mutator.next();
    ASSERT_NO_THROW(reader(text)) << "mutation " << i << ":\n" << text;
  }
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const auto& [name, unused] : readers()) all.push_back(name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(, Readers, testing::ValuesIn(names()), [](const auto& test) { return test.param; });

}  // namespace
}  // namespace sgraph::fuzz
