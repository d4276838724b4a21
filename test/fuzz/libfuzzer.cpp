// libFuzzer's entry: SGRAPH_FUZZ_READER=tum build/sanitize-address/devel/lib/sgraph_slam/fuzz_readers [libFuzzer's options] [folders]
#include <cstdio>
#include <cstdlib>

#include "readers.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const sgraph::fuzz::Reader& reader = []() -> const sgraph::fuzz::Reader& {
    const char* name = std::getenv("SGRAPH_FUZZ_READER");
    const auto found = sgraph::fuzz::readers().find(name == nullptr ? "" : name);
    if (found == sgraph::fuzz::readers().end()) {
      std::fputs("SGRAPH_FUZZ_READER must be one of:", stderr);
      for (const auto& [known, unused] : sgraph::fuzz::readers()) std::fprintf(stderr, " %s", known.c_str());
      std::fputs("\n", stderr);
      std::exit(2);
    }
    return found->second;
  }();
  reader({reinterpret_cast<const char*>(data), size});
  return 0;
}
