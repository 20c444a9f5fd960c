#include "nerf/script_module.h"

#include <stdexcept>

namespace structnerf {

torch::jit::Module LoadScriptModule(const std::string& path) {
  try {
    torch::jit::Module module = torch::jit::load(path);
    module.eval();
    return module;
  } catch (const std::exception& error) {
    throw std::runtime_error(
        path +
        " is not a TorchScript module that can be loaded: " + FirstLine(error));
  }
}

std::string FirstLine(const std::exception& error) {
  const std::string text = error.what();
  return text.substr(0, text.find('\n'));
}

}  // namespace structnerf
