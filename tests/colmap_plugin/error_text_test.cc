#include "colmap_plugin/error_text.h"

#include <new>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

template <typename Error>
std::string TextOf(const Error& error) {
  try {
    throw error;
  } catch (...) {
    return CurrentErrorText();
  }
}

TEST(ErrorText, IsASentenceForEveryType) {
  EXPECT_EQ(TextOf(std::runtime_error("The disk is full.")),
            "The disk is full.");
  EXPECT_THAT(TextOf(std::bad_alloc()), HasSubstr("memory"));
  EXPECT_THAT(TextOf(1), HasSubstr("unknown"));
}

}  // namespace
}  // namespace structnerf
