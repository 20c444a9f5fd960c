// The reader of field.bin. An input that is accepted must be the file that
// writing what was read gives.

#include "nerf/field/field_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temp_dir.h"

#include <exception>

namespace structnerf {
namespace {

const Eigen::Vector3f kExtent(1.0f, 0.5f, 0.75f);

FieldOptions Options() {
  FieldOptions options;
  options.num_levels = 1;
  options.log2_table_size = 10;
  options.min_resolution = 2;
  options.max_resolution = 2;
  options.hidden_width = 16;
  return options;
}

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  const FieldLayout layout(Options(), kExtent);
  const std::string path = Folder() / "seed.bin";
  WriteField(path, Options(), kExtent, InitialParameters(layout, 1.0f, 1));
  return {ReadFuzzFile(path)};
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  const std::string path = Folder() / "field.bin";
  WriteFuzzFile(path, data, size);
  try {
    const FieldParameters parameters = ReadField(path, Options(), kExtent);
    const std::string again = Folder() / "again.bin";
    WriteField(again, Options(), kExtent, parameters);
    if (ReadFuzzFile(again) !=
        std::string(reinterpret_cast<const char*>(data), size)) {
      FuzzFault("a changed field was taken for a good one");
    }
  } catch (const std::exception&) {
  }
  return 0;
}
