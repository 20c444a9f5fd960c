#include "colmap_plugin/json_text.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace structnerf {
namespace {

TEST(JsonText, IsIndentedAndEndsItsLine) {
  EXPECT_EQ(JsonText({{"a", 1}}), "{\n  \"a\": 1\n}\n");
}

TEST(JsonText, WhatIsNoUtf8IsReplaced) {
  const auto object = nlohmann::json::parse(JsonText({{"path", "a\xff.jpg"}}));
  EXPECT_EQ(object["path"], "a\xef\xbf\xbd.jpg");
}

}  // namespace
}  // namespace structnerf
