// Writes the seeds of the fuzzers: sanso-fuzz-seeds tests/fuzz/corpus
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/fuzz/seeds/seeds.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: sanso-fuzz-seeds FOLDER, e.g. tests/fuzz/corpus\n");
    return 2;
  }
  for (const auto& [target, seeds] : sanso::fuzz::seeds())
    for (const auto& [name, bytes] : seeds) {
      const auto folder = std::filesystem::path(argv[1]) / target;
      std::filesystem::create_directories(folder);
      std::ofstream file(folder / name, std::ios::binary);
      file.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
      if (!file.flush()) {
        std::fprintf(stderr, "%s: not written\n", (folder / name).c_str());
        return 2;
      }
    }
  return 0;
}
