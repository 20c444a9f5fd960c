#pragma once

#include <vector>

namespace structnerf {

// Makes a consistency graph in the form of COLMAP's: of each pixel that is
// confirmed, row by row, its column, its row, the number of views that confirm
// it and their indices into Scene::views, ascending.
class ConsistencyGraphBuilder {
 public:
  explicit ConsistencyGraphBuilder(int height);

  // Pixels of different rows may be added at the same time, those of one row
  // from left to right. `view_idxs`: ascending.
  void Add(int col, int row, const std::vector<int>& view_idxs);

  std::vector<int> Build() const;

 private:
  std::vector<std::vector<int>> rows_;
};

}  // namespace structnerf
