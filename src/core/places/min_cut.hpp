#pragma once

#include <cstddef>
#include <vector>

namespace sgraph {

/// A cut of least weight between a source and a sink in a graph of some hundred nodes (Dinic's algorithm).
class MinCut {
 public:
  explicit MinCut(std::size_t nodes) : edges_of_(nodes + 2), source_(nodes), sink_(nodes + 1) {}

  /// What it costs that a node lies on the sink's side, and on the source's.
  void add_node(std::size_t node, double on_sink_side, double on_source_side) {
    add_edge(source_, node, on_sink_side, 0);
    add_edge(node, sink_, on_source_side, 0);
  }
  /// What it costs that two nodes lie on different sides.
  void add_pair(std::size_t a, std::size_t b, double apart) { add_edge(a, b, apart, apart); }

  /// By node: whether it lies on the source's side.
  std::vector<char> solve();

 private:
  struct Edge {
    std::size_t to;
    double capacity;
  };
  void add_edge(std::size_t from, std::size_t to, double forth, double back) {
    edges_of_[from].push_back(edges_.size());
    edges_.push_back({to, forth});
    edges_of_[to].push_back(edges_.size());
    edges_.push_back({from, back});
  }
  bool find_levels();
  double push(std::size_t node, double most);

  std::vector<Edge> edges_;  // an edge and its reverse side by side
  std::vector<std::vector<std::size_t>> edges_of_;
  std::vector<int> level_;
  std::vector<std::size_t> next_;
  std::size_t source_;
  std::size_t sink_;
};

}  // namespace sgraph
