#include "colmap_plugin/log_level.h"

#include <memory>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(ScopedLogLevel, IsRestored) {
  const int before = FLAGS_minloglevel;
  {
    const ScopedLogLevel quiet(google::GLOG_ERROR);
    EXPECT_EQ(FLAGS_minloglevel, google::GLOG_ERROR);
    {
      const ScopedLogLevel less_quiet(google::GLOG_WARNING);
      EXPECT_EQ(FLAGS_minloglevel, google::GLOG_ERROR);
    }
    EXPECT_EQ(FLAGS_minloglevel, google::GLOG_ERROR);
  }
  EXPECT_EQ(FLAGS_minloglevel, before);
}

// As two threads may have it: the first to come is the first to go.
TEST(ScopedLogLevel, IsRestoredByTheLastToGo) {
  const int before = FLAGS_minloglevel;
  auto first = std::make_unique<ScopedLogLevel>(google::GLOG_ERROR);
  auto second = std::make_unique<ScopedLogLevel>(google::GLOG_FATAL);
  first.reset();
  EXPECT_EQ(FLAGS_minloglevel, google::GLOG_FATAL);
  second.reset();
  EXPECT_EQ(FLAGS_minloglevel, before);
}

}  // namespace
}  // namespace structnerf
