#pragma once

#include <exception>
#include <string>

#include <torch/script.h>

namespace structnerf {

// A TorchScript module of the user, for inference. Throws std::runtime_error,
// naming the file, if it is none.
torch::jit::Module LoadScriptModule(const std::string& path);

// What LibTorch says in the first line; the rest is a trace of its own calls.
std::string FirstLine(const std::exception& error);

}  // namespace structnerf
