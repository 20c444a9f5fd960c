#include "nerf/util/whole_file.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace structnerf {

void WriteWholeFile(const std::string& path,
                    const std::function<void(std::ostream*)>& write) {
  const std::string partial_path = path + ".partial";
  std::ofstream file(partial_path, std::ios::binary | std::ios::trunc);
  write(&file);
  file.close();
  std::error_code error;
  if (!file.fail()) {
    std::filesystem::rename(partial_path, path, error);
  }
  if (file.fail() || error) {
    std::filesystem::remove(partial_path, error);
    throw std::runtime_error("The file " + path +
                             " could not be written; is the disk full?");
  }
}

}  // namespace structnerf
