#include "nerf/perceptual_module.h"

#include "tests/support/temp_dir.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/script.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 16;
constexpr int kHeight = 12;

class PerceptualModuleTest : public testing::Test {
 protected:
  // A module whose forward(a, b) does this.
  std::string WriteModule(const std::string& body) const {
    torch::jit::Module module("distance");
    module.define("def forward(self, a, b):\n  " + body + "\n");
    module.save(temp_dir_ / "distance.pt");
    return temp_dir_ / "distance.pt";
  }

  template <typename Function>
  static std::string ErrorOf(Function function) {
    try {
      function();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  // One colour each.
  static std::vector<float> MakeImage(float red, float green, float blue) {
    std::vector<float> image;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      image.insert(image.end(), {red, green, blue});
    }
    return image;
  }

  TempDir temp_dir_;
  const std::vector<float> image_ = MakeImage(0.5, 0.25, 0);
  const std::vector<float> reference_ = MakeImage(0.25, 0.25, 0.25);
};

TEST_F(PerceptualModuleTest, GivesTheModuleBothImagesFromMinusOneToOne) {
  // Channels are the second dimension, red is the first.
  const PerceptualModule red(
      WriteModule("return (a - b)[0, 0].mean().reshape([1, 1, 1, 1])"));
  EXPECT_NEAR(red.Measure(kWidth, kHeight, image_, reference_), 0.5, 1e-6);
  const PerceptualModule blue(WriteModule("return a[0, 2, 11, 15]"));
  EXPECT_NEAR(blue.Measure(kWidth, kHeight, image_, reference_), -1, 1e-6);
}

TEST_F(PerceptualModuleTest, NamesAFileThatIsNoModule) {
  std::ofstream(temp_dir_ / "text.pt") << "text";
  EXPECT_THAT(ErrorOf([&]() { PerceptualModule(temp_dir_ / "text.pt"); }),
              HasSubstr("text.pt is not a TorchScript module"));
}

TEST_F(PerceptualModuleTest, NamesAModuleThatDoesNotFit) {
  for (const char* body : {"return a - b", "return (a - b).sum() / 0"}) {
    const PerceptualModule distance(WriteModule(body));
    EXPECT_THAT(
        ErrorOf([&]() { distance.Measure(kWidth, kHeight, image_, image_); }),
        HasSubstr("distance.pt must map two images"))
        << body;
  }
}

}  // namespace
}  // namespace structnerf
