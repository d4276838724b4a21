#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace sgraph::fuzz {

/// Feeds bytes to one of the package's readers as if they came from outside: a message, a file. A reader may refuse them with the exception that it
/// documents; everything else (another exception, a crash, a sanitizer's report, a result that breaks its contract) is a defect.
using Reader = std::function<void(std::string_view bytes)>;

/// Every reader by name; the corpus of each is the folder of that name in test/fuzz/corpus.
const std::map<std::string, Reader>& readers();

/// Ends the program with a message: the result breaks the reader's contract.
void expect(bool holds, const char* what);

/// A file with the bytes, in memory where the system can do that; gone with the object.
class ScratchFile {
 public:
  explicit ScratchFile(std::string_view bytes);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  int descriptor_;
  std::string path_;
};

void read_point_cloud(std::string_view bytes);
void read_velodyne_scan(std::string_view bytes);
void read_store(std::string_view bytes);
void read_stored_cloud(std::string_view bytes);

}  // namespace sgraph::fuzz
