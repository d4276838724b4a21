// A map file of arbitrary bytes, and a cloud in one whose checksum is right.
#include <unistd.h>
#include <zstd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "readers.hpp"
#include "sgraph_slam/core/store/cloud_codec.hpp"
#include "sgraph_slam/core/store/map_store.hpp"
#include "sgraph_slam/core/store/stored_map.hpp"

namespace sgraph::fuzz {

namespace {

/// A file with a name of its own: SQLite looks for a log beside it. In memory where there is /dev/shm.
class NamedFile {
 public:
  explicit NamedFile(std::string_view bytes) {
    const std::filesystem::path memory("/dev/shm");
    std::error_code error;
    const auto folder = std::filesystem::is_directory(memory, error) ? memory : std::filesystem::temp_directory_path();
    path_ = (folder / ("sgraph_fuzz_" + std::to_string(getpid()) + ".sgmap")).string();
    std::ofstream(path_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  ~NamedFile() {
    std::error_code error;
    for (const char* part : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(path_ + part, error);
  }
  NamedFile(const NamedFile&) = delete;
  NamedFile& operator=(const NamedFile&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

void read_store(std::string_view bytes) {
  const NamedFile file(bytes);
  try {
    snapshot_of(read_map(file.path(), Clouds::all));
    summarize_map(file.path());
    check_map(file.path());
  } catch (const StoreError& error) {
    expect(std::string(error.what()).rfind(file.path(), 0) == 0, "an error names the file");
  }
}

void read_stored_cloud(std::string_view bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 1);
  expect(ZSTD_isError(size) == 0, "bytes can be compressed");
  packed.resize(size);
  try {
    const Cloud cloud = decode_cloud(packed);
    for (const Point& point : cloud.points) expect(point.position().allFinite(), "positions are finite");
    expect(decode_cloud(encode_cloud(cloud)).size() <= cloud.size(), "a cloud that was read can be written and read again");
  } catch (const std::runtime_error&) {
  }
}

}  // namespace sgraph::fuzz
