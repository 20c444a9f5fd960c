#include "nerf/engine/devices.h"

#include "nerf/engine/render_engine.h"

#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

EngineOptions SmallOptions() {
  EngineOptions options;
  options.field.log2_table_size = 10;
  options.field.max_resolution = 32;
  options.field.mlp_num_layers = 1;
  options.field.mlp_width = 2;
  options.sampling.cache_resolution = 8;
  options.num_threads = 1;
  return options;
}

size_t NumParameters(const std::string& device, const std::string& field_type) {
  EngineOptions options = SmallOptions();
  options.field.type = field_type;
  const EngineFactory make_engine = EnginesOfDevice(
      device, [](const std::string& warning) { FAIL() << warning; });
  return make_engine(options)->NumParameters();
}

TEST(Devices, TheProcessorHasEveryField) {
  for (const char* field_type : {"grid", "mlp"}) {
    EXPECT_EQ(ResolveDevice("cpu", field_type), "cpu");
    EXPECT_GT(NumParameters("cpu", field_type), 0u);
  }
}

TEST(Devices, OthersAreRefusedByName) {
  for (const char* device : {"gpu", "", "CUDA"}) {
    EXPECT_THAT([&]() { ResolveDevice(device, "grid"); },
                ThrowsMessage<std::invalid_argument>(
                    HasSubstr(std::string("--StructNeRF.device is ") + device +
                              ", but must be auto, cpu or cuda.")))
        << device;
    EXPECT_THROW(EnginesOfDevice(device, nullptr), std::invalid_argument);
  }
}

TEST(Devices, AGraphicsCardHasTheGridOnly) {
  EXPECT_EQ(ResolveDevice("auto", "mlp"), "cpu");
  EXPECT_THAT([]() { ResolveDevice("cuda", "mlp"); },
              ThrowsMessage<std::invalid_argument>(
                  AllOf(HasSubstr("--StructNeRF.device is cuda, but "),
                        HasSubstr("; choose auto or cpu."))));
  EXPECT_THROW(NumParameters("cuda", "mlp"), std::invalid_argument);
}

// Whether the program knows graphics cards, and whether there is one, or not.
TEST(Devices, AGraphicsCardIsUsedOrSaidToBeMissing) {
  const std::string device = ResolveDevice("auto", "grid");
  if (device == "cuda") {
    EXPECT_EQ(ResolveDevice("cuda", "grid"), "cuda");
    EXPECT_EQ(NumParameters("cuda", "grid"), NumParameters("cpu", "grid"));
    return;
  }
  EXPECT_EQ(device, "cpu");
  EXPECT_THAT([]() { ResolveDevice("cuda", "grid"); },
              ThrowsMessage<std::invalid_argument>(
                  AllOf(HasSubstr("--StructNeRF.device is cuda, but "),
                        HasSubstr("; choose auto or cpu."))));
}

}  // namespace
}  // namespace structnerf
