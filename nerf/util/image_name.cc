#include "nerf/util/image_name.h"

#include <algorithm>
#include <filesystem>

namespace structnerf {
namespace {

bool IsControl(const unsigned char c) { return c < 0x20 || c == 0x7f; }

}  // namespace

bool IsSafeImageName(const std::string& name) {
  const std::filesystem::path path(name);
  return !name.empty() && path.is_relative() && path.has_filename() &&
         std::none_of(
             path.begin(),
             path.end(),
             [](const std::filesystem::path& part) { return part == ".."; }) &&
         std::none_of(name.begin(), name.end(), IsControl);
}

std::string Printable(std::string name) {
  std::replace_if(name.begin(), name.end(), IsControl, '?');
  return name;
}

}  // namespace structnerf
