#include "colmap_plugin/run_expectation.h"

#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

class RunExpectationTest : public testing::Test {
 protected:
  RunExpectation Expect(const int num_images) {
    const TempDir folder;
    MakeTinyModel(num_images).WriteModel(folder / "model");
    return RunForecast(std::make_shared<const colmap::Reconstruction>(
                           ReadModel(folder / "model")))
        .Expect(options_);
  }

  StructNerfOptions options_;
};

TEST_F(RunExpectationTest, SaysWhatWillBeDone) {
  const RunExpectation expectation = Expect(3);
  EXPECT_TRUE(expectation.is_possible);
  EXPECT_THAT(expectation.text, HasSubstr("3 images and 9 points"));
  EXPECT_THAT(expectation.text, HasSubstr("1500 steps"));
  EXPECT_THAT(expectation.text, HasSubstr("64 pixels"));
  EXPECT_THAT(expectation.text, HasSubstr("of memory"));
  EXPECT_THAT(expectation.text, HasSubstr("scene box"));
  EXPECT_THAT(expectation.text, HasSubstr("768 cells along the box (as told)"));
  options_.reconstruction = QualityPreset("medium");
  EXPECT_THAT(Expect(3).text, HasSubstr("a training pixel covers"));
}

TEST_F(RunExpectationTest, SaysWhyItCannotBeDone) {
  const RunExpectation too_few = Expect(1);
  EXPECT_FALSE(too_few.is_possible);
  EXPECT_THAT(too_few.text, HasSubstr("image"));

  options_.max_memory_gb = 0.01;
  const RunExpectation too_big = Expect(3);
  EXPECT_FALSE(too_big.is_possible);
  EXPECT_THAT(too_big.text, HasSubstr("max_memory_gb"));
}

}  // namespace
}  // namespace structnerf
