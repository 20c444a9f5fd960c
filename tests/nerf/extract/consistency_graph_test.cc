#include "nerf/extract/consistency_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(ConsistencyGraphBuilder, WhereNothingIsConfirmedItIsEmpty) {
  EXPECT_THAT(ConsistencyGraphBuilder(3).Build(), IsEmpty());
}

TEST(ConsistencyGraphBuilder, GoesRowByRowInWhateverOrderTheyAreTold) {
  ConsistencyGraphBuilder builder(3);
  builder.Add(7, 2, {4});
  builder.Add(1, 0, {0, 3});
  builder.Add(8, 2, {});
  builder.Add(5, 0, {2});
  EXPECT_THAT(builder.Build(),
              ElementsAre(1, 0, 2, 0, 3, 5, 0, 1, 2, 7, 2, 1, 4, 8, 2, 0));
}

}  // namespace
}  // namespace structnerf
