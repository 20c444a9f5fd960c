#pragma once

#include <string>

#include <gtest/gtest.h>
#include <hwy/highway.h>

namespace structnerf {

// Runs each test of a suite once for every instruction set that is compiled in
// and that this machine has.
class SimdTargetTest : public testing::TestWithParam<int64_t> {
 protected:
  void SetUp() override { Select(GetParam()); }
  void TearDown() override { Select(0); }

 private:
  // 0 = all.
  static void Select(const int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

inline std::string SimdTargetName(
    const testing::TestParamInfo<int64_t>& target) {
  return hwy::TargetName(target.param);
}

#define STRUCTNERF_FOR_EACH_SIMD_TARGET(suite)                  \
  INSTANTIATE_TEST_SUITE_P(                                     \
      Simd,                                                     \
      suite,                                                    \
      testing::ValuesIn(::hwy::SupportedAndGeneratedTargets()), \
      ::structnerf::SimdTargetName)

}  // namespace structnerf
