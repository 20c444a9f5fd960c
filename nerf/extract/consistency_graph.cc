#include "nerf/extract/consistency_graph.h"

#include <cstddef>

namespace structnerf {

ConsistencyGraphBuilder::ConsistencyGraphBuilder(const int height)
    : rows_(height) {}

void ConsistencyGraphBuilder::Add(const int col,
                                  const int row,
                                  const std::vector<int>& view_idxs) {
  std::vector<int>& records = rows_[row];
  records.insert(records.end(), {col, row, static_cast<int>(view_idxs.size())});
  records.insert(records.end(), view_idxs.begin(), view_idxs.end());
}

std::vector<int> ConsistencyGraphBuilder::Build() const {
  size_t size = 0;
  for (const std::vector<int>& records : rows_) {
    size += records.size();
  }
  std::vector<int> graph;
  graph.reserve(size);
  for (const std::vector<int>& records : rows_) {
    graph.insert(graph.end(), records.begin(), records.end());
  }
  return graph;
}

}  // namespace structnerf
